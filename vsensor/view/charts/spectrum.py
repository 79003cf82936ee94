"""How bit and surface swing: amplitude by frequency, with the string's natural frequencies marked."""

from collections import deque
from collections.abc import Iterator

import numpy as np

from vsensor.grid import NS
from vsensor.messages import Description, Estimate, Message
from vsensor.view.batches import Batch, Floats, Labels, Strokes
from vsensor.view.charts.chart import HEIGHT, LIFT, Axis, Chart
from vsensor.view.palette import BLUE, GREY, YELLOW
from vsensor.view.part import Every, Part
from vsensor.view.units import Units

EVERY_NS = NS
SPACING_NS = 20_000_000
"""Of what is kept; the swings are below 5 Hz."""
HIGHEST_HZ = 4.0
DECADES = 5


class Spectrum(Part):
    """Amplitudes of bit speed and top speed, confirmed, over the last `span_s` seconds."""

    def __init__(self, entity: str, units: Units, span_s: float) -> None:
        self._factor = units.speed_factor
        self._chart = Chart(entity, "frequency, Hz", f"amplitude, {units.speed}")
        self._kept: deque[tuple[int, float, float]] = deque(maxlen=round(span_s * 1e9 / SPACING_NS))
        self._modes: list[float] = []
        self._entity = entity
        self._every = Every(EVERY_NS)

    def take(self, message: Message) -> None:
        """Take in a confirmed answer, or the string's modes."""
        if isinstance(message, Description):
            self._modes = [hz for hz in message.mode_hz if hz <= HIGHEST_HZ]
        elif isinstance(message, Estimate) and message.HasField("top_speed_rad_s"):
            time_ns = message.confirmed_time_ns
            if self._kept and time_ns < self._kept[-1][0]:
                self._kept.clear()
            if not self._kept or time_ns - self._kept[-1][0] >= SPACING_NS:
                self._kept.append((time_ns, message.confirmed_bit_speed_rad_s, message.top_speed_rad_s))

    def batches(self) -> Iterator[Batch]:
        """The spectra, once a second."""
        if len(self._kept) < 256 or not self._every.due(self.at_ns):
            return
        times, bit, top = np.array(self._kept).T
        hz, bit_swing = amplitudes(times / 1e9, bit * self._factor)
        _, top_swing = amplitudes(times / 1e9, top * self._factor)
        shown = (hz > 0) & (hz <= HIGHEST_HZ)
        highest = np.ceil(np.log10(max(bit_swing[shown].max(), top_swing[shown].max(), 1e-3)))
        x, y = Axis(0.0, HIGHEST_HZ, 1.0), _Powers(highest - DECADES, highest, 1.0)
        yield from self._chart.frame(self.at_ns, x, y)
        for name, swing, colour in (("top", top_swing, GREY), ("top/bit", bit_swing, BLUE)):
            levels = np.maximum(np.log10(np.maximum(swing[shown], 1e-12)), y.low)
            yield self._chart.curve(name, self.at_ns, hz[shown], levels, colour)
        yield from self._marks(self.at_ns, y)
        entries = [("bit", BLUE), ("top of the string", GREY), ("natural frequency", YELLOW)]
        yield self._chart.legend(self.at_ns, entries)

    def _marks(self, at_ns: int, y: Axis) -> Iterator[Batch]:
        if not self._modes:
            return
        places = self._chart.places(np.array(self._modes), np.full(len(self._modes), y.high))
        lines = tuple(np.array([place, np.add(place, [0.0, HEIGHT])]) for place in places)
        colour = (*YELLOW[:3], 110)
        yield Strokes(f"{self._entity}/modes", at_ns, lines, (colour,) * len(lines), 1.0)
        texts = tuple(f"{hz:.2f}" for hz in self._modes)
        yield Labels(
            f"{self._entity}/modes/names", at_ns, places - [0.0, 2 * LIFT], texts, (YELLOW,) * len(texts)
        )


class _Powers(Axis):
    """An axis of powers of ten."""

    def text(self, value: float) -> str:
        return f"{10.0**value:g}"


def amplitudes(times_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Frequencies, Hz, and amplitudes of the sines at them, after the mean is taken off.

    Values are interpolated onto even times; Hann's window is scaled so that a sine's peak is its amplitude.
    """
    even = np.linspace(times_s[0], times_s[-1], len(times_s))
    window = np.hanning(len(even))
    swing = np.interp(even, times_s, values)
    spectrum = np.fft.rfft((swing - swing.mean()) * window)
    hz = np.fft.rfftfreq(len(even), (even[-1] - even[0]) / (len(even) - 1))
    return hz, 2 * np.abs(spectrum) / window.sum()
