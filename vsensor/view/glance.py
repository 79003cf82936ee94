"""The large figures: what a driller sees who looks up for one second.

A picture of five tiles. Rerun has no text larger than a heading; this is read from across the floor.
"""

import io
import math
from collections.abc import Iterator
from functools import cache
from typing import cast

from PIL import Image, ImageDraw, ImageFont

from vsensor.messages import Estimate, Message, Profile, Status, Tick
from vsensor.view import series
from vsensor.view.batches import Batch, Colour, Picture
from vsensor.view.palette import DIM, GREEN, GREY, GROUND, ORANGE, VERMILION, WHITE, YELLOW
from vsensor.view.part import FIGURES_EVERY_NS, Beat, Part
from vsensor.view.plots import Drive
from vsensor.view.readings import reading
from vsensor.view.units import Units
from vsensor.view.verdicts import Grade, Verdict, bit_state, roughness, strength, trust
from vsensor.view.words import clock

HEIGHT = 170
TILES = (440, 360, 520, 370, 370)
"""Their widths: bit, surface, torque, stick-slip, trust."""
GAP = 8
_GRADES = {Grade.UNKNOWN: DIM, Grade.WELL: GREEN, Grade.CARE: YELLOW, Grade.ALARM: VERMILION}
_BLACK = (0, 0, 0, 255)
_TILE = (28, 32, 34, 255)


class Glance(Part):
    """The newest of everything, in five tiles."""

    def __init__(self, units: Units, drive: Drive) -> None:
        self._units = units
        self._drive = drive
        self._tick = Tick()
        self._estimate = Estimate()
        self._status = Status()
        self._profile = Profile()
        self._silent_s = 0.0
        self._beat = Beat(FIGURES_EVERY_NS)
        self._last = b""

    def take(self, message: Message) -> None:
        """Take in one message."""
        match message:
            case Tick():
                self._tick, self._silent_s = message, 0.0
            case Estimate():
                self._estimate = message
            case Status():
                self._status = message
            case Profile():
                self._profile = message

    def silent(self, seconds: float, at_ns: int) -> None:
        """Say that nothing has come for so long: what was known is so no more."""
        self._silent_s, self.at_ns = seconds, at_ns

    def batches(self) -> Iterator[Batch]:
        """The picture, four times a second where it has changed."""
        if not self._silent_s and not self._beat.due(self.at_ns):
            return
        picture = self.picture()
        if picture != self._last:
            self._last = picture
            yield Picture(series.GLANCE, self.at_ns, picture)

    def picture(self) -> bytes:
        """The tiles as PNG."""
        width = sum(TILES) + GAP * (len(TILES) - 1)
        image = Image.new("RGB", (width, HEIGHT), GROUND[:3])
        left = 0
        draws = (self._bit, self._surface, self._torque, self._roughness, self._trust)
        for tile_width, draw in zip(TILES, draws, strict=True):
            draw(Tile(ImageDraw.Draw(image), left, tile_width))
            left += tile_width + GAP
        file = io.BytesIO()
        image.quantize(64, Image.Quantize.FASTOCTREE).save(file, "PNG", compress_level=1)
        return file.getvalue()

    @property
    def _known(self) -> bool:
        return not self._silent_s and trust(self._estimate).grade in (Grade.WELL, Grade.CARE)

    def _bit(self, tile: "Tile") -> None:
        now = reading(self._estimate, "now", self._units)
        state = bit_state(self._estimate, "now") if self._known else Verdict("", Grade.UNKNOWN)
        sticks = self._estimate.stick_in_s if self._estimate.HasField("stick_in_s") else 0.0
        if self._known and sticks > 0:
            state = Verdict(f"sticks in {sticks:.1f} s", Grade.CARE)
        ground = _TILE if state.grade in (Grade.UNKNOWN, Grade.WELL) else _GRADES[state.grade]
        tile.fill(ground)
        ink = ORANGE if ground == _TILE else _BLACK
        tile.title(f"BIT NOW, {self._units.speed}", "" if not self._known else state.word)
        tile.figure(
            self._units.speed_text(now.speed) if self._known and not math.isnan(now.speed) else "?", ink
        )
        if self._known and not math.isnan(now.speed_std):
            tile.foot(f"± {self._units.speed_text(2 * now.speed_std)}")

    def _surface(self, tile: "Tile") -> None:
        tile.fill(_TILE)
        tile.title(f"SURFACE, {self._units.speed}")
        known = self._tick.HasField("motor_speed_rad_s") and not self._silent_s
        speed = self._tick.motor_speed_rad_s * self._units.speed_factor / self._drive.gear_ratio
        tile.figure(self._units.speed_text(speed) if known else "?", WHITE)

    def _torque(self, tile: "Tile") -> None:
        units = self._units
        surface = (
            self._tick.motor_torque_nm * units.torque_factor * self._drive.gear_ratio * self._drive.efficiency
        )
        verdict = strength(self._profile) if self._known else Verdict("", Grade.UNKNOWN)
        tile.fill(_TILE)
        tile.title(f"TORQUE, {units.torque}")
        now = reading(self._estimate, "now", units)
        bit = units.torque_text(now.torque) if self._known and not math.isnan(now.torque) else "?"
        known = self._tick.HasField("motor_torque_nm") and not self._silent_s
        tile.pair(("bit", bit, ORANGE), ("surface", units.torque_text(surface) if known else "?", WHITE))
        if verdict.grade is Grade.UNKNOWN:
            tile.foot("no limit known")
        else:
            used = 1 - self._profile.weakest_margin
            tile.bar(
                used,
                _GRADES[verdict.grade],
                f"{self._profile.weakest_component}: {used:.0%} of the {self._profile.weakest_limited_by}",
            )

    def _roughness(self, tile: "Tile") -> None:
        verdict = roughness(self._status) if self._known else Verdict("", Grade.UNKNOWN)
        tile.state(
            "STICK-SLIP",
            verdict,
            f"severity {self._status.severity:.2f}" if verdict.word else "not known yet",
        )

    def _trust(self, tile: "Tile") -> None:
        if self._silent_s:
            tile.state(
                "TRUST", Verdict("no word", Grade.ALARM), f"for {self._silent_s:.0f} s: all here is old"
            )
            return
        verdict = trust(self._estimate)
        why = verdict.why or (
            f"confirmed {self._status.confirmed_delay_s:.1f} s later" if verdict.word else self._status.state
        )
        # A page that is slow to draw is behind, and cannot know it: who looks has a clock.
        at = f"at {clock(self.at_ns)} UTC" if self.at_ns else ""
        tile.state("TRUST", verdict if verdict.word else Verdict("wait", Grade.UNKNOWN), why, at)


class Tile:
    """A rectangle of the picture: a title, one thing large, a line below."""

    def __init__(self, draw: ImageDraw.ImageDraw, left: int, width: int) -> None:
        self._draw = draw
        self._left = left
        self._width = width
        self._ink: Colour = GREY

    def fill(self, colour: Colour) -> None:
        """Paint the ground; what is written on a bright one is black."""
        self._draw.rounded_rectangle(
            (self._left, 0, self._left + self._width - 1, HEIGHT - 1), 10, colour[:3]
        )
        self._ink = GREY if colour in (_TILE, DIM) else _BLACK

    def title(self, text: str, aside: str = "") -> None:
        """What it is, at the left above, and a word at the right."""
        self._text((self._left + 14, 10), text, 22, self._ink)
        if aside:
            self._text((self._left + self._width - 14, 10), aside, 22, self._ink, anchor="ra")

    def figure(self, text: str, colour: Colour) -> None:
        """One number, as large as it goes."""
        self._text((self._left + 14, 150), text, 120, colour, anchor="ls")

    def foot(self, text: str) -> None:
        """A line at the right below."""
        self._text((self._left + self._width - 14, 152), text, 26, self._ink, anchor="rs")

    def pair(self, *figures: tuple[str, str, Colour]) -> None:
        """Two numbers beside one another, each named."""
        for place, (name, text, colour) in enumerate(figures):
            left = self._left + 14 + place * (self._width // 2)
            self._text((left, 104), text, 62, colour, anchor="ls")
            width = self._draw.textlength(text, _font(62))
            self._text((left + width + 8, 104), name, 22, self._ink, anchor="ls")

    def bar(self, share: float, colour: Colour, text: str) -> None:
        """How much of something is used up."""
        left, right, top = self._left + 14, self._left + self._width - 14, 116
        self._draw.rectangle((left, top, right, top + 14), DIM[:3])
        used = left + round((right - left) * min(max(share, 0.0), 1.0))
        self._draw.rectangle((left, top, used, top + 14), colour[:3])
        self._text((left, 156), text, 20, self._ink, anchor="ls")

    def state(self, title: str, verdict: Verdict, why: str, aside: str = "") -> None:
        """A word on its colour."""
        self.fill(_GRADES[verdict.grade])
        self.title(title, aside)
        self._text((self._left + 14, 112), verdict.word.upper() or "?", 52, self._ink, anchor="ls", fit=True)
        self._text((self._left + 14, 152), why, 24, self._ink, anchor="ls", fit=True)

    def _text(
        self,
        at: tuple[int | float, int],
        text: str,
        size: int,
        colour: Colour,
        anchor: str = "la",
        fit: bool = False,
    ) -> None:
        while fit and size > 12 and self._draw.textlength(text, _font(size)) > self._width - 28:
            size -= 2
        self._draw.text(
            at, text.replace("−", "-"), colour[:3], _font(size), anchor=anchor
        )  # the font has no minus


@cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    """Pillow's own font, so that it looks alike on every machine."""
    return cast("ImageFont.FreeTypeFont", ImageFont.load_default(size))
