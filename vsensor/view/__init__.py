"""The live view: what the rig and the sensor say, drawn by Rerun, in a process of its own."""
