"""A bare Zenoh echo: `python -m vsensor.bench.echo ENDPOINT BYTES` sends so many bytes for each message.

The yardstick of the sensor's latency: it does nothing in between. Ends with its standard input.
"""

import sys

import zenoh

from vsensor.bus import open_session
from vsensor.config import Bus

ASKED, ANSWERED = "echo/asked", "echo/answered"


def main(endpoint: str, size: int) -> None:
    """Listen at the endpoint, as the daemon does, until standard input is closed."""
    with open_session(Bus(listen=(endpoint,)), "daemon") as session:
        answers = session.declare_publisher(
            ANSWERED, congestion_control=zenoh.CongestionControl.DROP, express=True
        )

        def answer(asked: zenoh.Sample) -> None:
            answers.put(asked.payload.to_bytes().ljust(size, b"\0"))

        asked = session.declare_subscriber(ASKED, answer)
        sys.stdout.write("READY\n")
        sys.stdout.flush()
        sys.stdin.read()
        asked.undeclare()  # type: ignore[no-untyped-call]


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
