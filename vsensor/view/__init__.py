"""The live view: what the rig and the sensor say, drawn by Rerun, in a process of its own."""

import os

# A file that is written for days has no footer (see screen), of which Rerun would warn each time.
os.environ.setdefault("RUST_LOG", "warn,re_log_encoding=error")
