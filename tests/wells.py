"""Wells of many kinds, simulated on a fine grid: the truth is known, and so is the configuration.

What a well is made of was put down once, as one finds it on rigs, and not looked at again for what the
sensor makes of it: usual drill pipe of 5 in, a third of the hole each of heavy-weight pipe and of collars,
but no more than 150 m; a stiff speed controller, ten radians a second and then half as much again; rock
that takes 6 kN·m to break loose and 3 kN·m while the bit turns.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.leapfrog import Drive, Law, Part, Record, Well, simulate
from vsensor.config import Rig
from vsensor.tables import SurfaceTable
from vsensor.units import factor

RPM = factor("rpm", "rad/s")
LENGTHS_M = (150, 400, 800, 1500, 2500, 4000, 6000, 9000)
BHA_M = 150.0
PIPE = Part(0.0, 0.0635, 0.0543, c=0.02, fs=0.3)
HEAVY = Part(0.0, 0.0635, 0.0381, c=0.02, fs=0.4)
COLLARS = Part(0.0, 0.0826, 0.0357, c=0.02, fs=0.5)
ROCK = Law(viscous=10.0, kinetic=3e3, static=6e3, stribeck=1.5)
OFF_BOTTOM = Law(viscous=2.0)
STIFF = Drive(kp=20e3, ki=8e3, limit=50e3)
SOFT = Drive(kp=2500.0, ki=1200.0, limit=50e3)
"""As the string's own impedance or a little more: it swallows a part of each wave."""


class Case(NamedTuple):
    """A well, and what becomes of its readings on the way to the sensor."""

    words: str
    well: Well
    spoilt: Callable[[Record], Record] = lambda record: record

    @property
    def rig(self) -> Rig:
        """Its right configuration."""
        return rig_of(self.well)

    def record(self, seed: int = 1) -> Record:
        """What is measured, and what is true."""
        return self.spoilt(simulate(self.well, seed))


def string(length: float) -> tuple[Part, ...]:
    """The usual string of a length, m."""
    bha = min(BHA_M, length / 3)
    return _of(length - 2 * bha, PIPE), _of(bha, HEAVY), _of(bha, COLLARS)


def usual(length: float) -> Well:
    """A well of a length, m, with nothing unusual."""
    return Well(
        string=string(length),
        command=((0, 0), (5, 10), (45, 10), (50, 15)),
        law=((0.0, ROCK),),
        drive=STIFF,
        drive_inertia=2000.0,
        bit_inertia=50.0,
        rock=(300.0, 0.3),
        torque_noise=80.0,
        speed_noise=0.015,
        torque_lag=0.005,
        duration=90.0,
    )


def rig_of(well: Well) -> Rig:
    """The configuration that tells all of a well as it is, the law as it is in the end."""
    law = well.law[-1][1]
    return Rig.model_validate(
        {
            "rig": {"name": "simulated"},
            "string": [
                {
                    "length": part.length,
                    "outer_diameter": 2 * part.ro,
                    "inner_diameter": 2 * part.ri,
                    "density": part.rho,
                    "shear_modulus": part.G,
                    "viscous_friction": part.c,
                    "coulomb_friction": part.fs if part.fd is None else part.fd,
                    "static_friction": part.fs,
                }
                for part in well.string
            ],
            "top_drive": {"inertia": well.drive_inertia, "torque_lag": well.torque_lag},
            "bit": {
                "inertia": well.bit_inertia,
                "viscous_friction": law.viscous,
                "kinetic_torque": law.kinetic,
                "static_torque": law.static,
                "stribeck_speed": law.stribeck,
            },
            "measurement": {"torque_noise": well.torque_noise, "speed_noise": well.speed_noise},
            "loop": {"rate": well.rate},
        }
    )


def surface(record: Record) -> SurfaceTable:
    """What is measured, as the sensor reads it."""
    return SurfaceTable.at_seconds(record.time, record.motor_torque, record.motor_speed)


def _of(length: float, part: Part) -> Part:
    return part._replace(length=length)


def _tapered() -> Well:
    """Pipe of 5 7/8, 5 1/2, 5 and 4 in, heavy-weight pipe, collars of 8 and 6 1/2 in."""
    walls = (
        (1200.0, 0.0746, 0.0654),
        (1000.0, 0.0699, 0.0607),
        (800.0, 0.0635, 0.0543),
        (400.0, 0.0508, 0.0424),
        (150.0, 0.0635, 0.0381),
        (60.0, 0.1016, 0.0357),
        (90.0, 0.0826, 0.0357),
    )
    return usual(0.0)._replace(string=tuple(Part(*wall, c=0.02, fs=0.3) for wall in walls))


def _lateral() -> Well:
    """Off bottom; static friction is 1.43 times the kinetic one."""
    vertical, lateral = PIPE._replace(fs=0.2, fd=0.14), PIPE._replace(fs=6.0, fd=4.2)
    heavy, collars = HEAVY._replace(fs=9.0, fd=6.3), COLLARS._replace(fs=12.0, fd=8.4)
    parts = _of(1800.0, vertical), _of(1000.0, lateral), _of(150.0, heavy), _of(90.0, collars)
    return usual(0.0)._replace(string=parts, law=((0.0, OFF_BOTTOM),), rock=(0.0, 1.0))


def _heavily_rubbed() -> Well:
    """Kinetic friction of the wall takes about as much as the rock."""
    pipe, heavy, collars = string(2500.0)
    return usual(0.0)._replace(
        string=(pipe._replace(fs=1.5), heavy._replace(fs=2.0), collars._replace(fs=2.5))
    )


def _smooth(length: float) -> Well:
    """Fast and softly held, in rock of which little more is asked to break loose than to turn."""
    law = Law(viscous=120.0, kinetic=2500.0, static=3500.0, stribeck=3.0)
    return usual(length)._replace(
        command=((0, 0), (8, 14), (45, 14), (50, 17)),
        drive=SOFT,
        drive_inertia=2900.0,
        law=((0.0, law),),
        rock=(500.0, 0.3),
    )


def _slow() -> Well:
    """Hard rock, slowly turned, at the end of a long string."""
    law = ROCK._replace(kinetic=4e3, static=9e3)
    return usual(5000.0)._replace(command=((0, 0), (5, 5), (45, 5), (50, 7)), law=((0.0, law),))


def _hard() -> Well:
    """Collars right below the pipe in a hole without friction, and rock that takes 8 kN·m to break loose.

    The bit darts, and the collars ring with it for seconds.
    """
    return usual(1200)._replace(
        string=(_of(1200.0, PIPE)._replace(fs=0.0), _of(BHA_M, COLLARS)._replace(fs=0.0)),
        command=((0, 0), (5, 8)),
        law=((0.0, ROCK._replace(static=8e3)),),
        rock=(150.0, 0.4),
    )


def _set_down() -> Well:
    """Turning off bottom for half a minute, then set on bottom within three seconds."""
    return usual(2500.0)._replace(law=((0.0, OFF_BOTTOM), (30.0, OFF_BOTTOM), (33.0, ROCK)))


def _lab() -> Well:
    """Five metres of 6 mm wire, a flywheel for a bit."""
    return Well(
        string=(Part(5.0, 0.003, 0.0, c=1e-4, fs=1e-3),),
        command=((0, 0), (5, 10), (45, 10), (50, 15)),
        law=((0.0, Law(viscous=0.01, kinetic=2.0, static=4.0, stribeck=1.5)),),
        drive=Drive(kp=20.0, ki=8.0, limit=50.0),
        drive_inertia=0.5,
        bit_inertia=0.05,
        rock=(0.2, 0.3),
        torque_noise=0.05,
        speed_noise=0.015,
        torque_lag=0.005,
        duration=90.0,
    )


def _in_steps(record: Record) -> Record:
    torque, speed = 100.0, 0.1 * RPM
    return record._replace(
        motor_torque=np.rint(record.motor_torque / torque) * torque,
        motor_speed=np.rint(record.motor_speed / speed) * speed,
    )


GAP_S, EVERY_S = 0.5, 7.0


def _gaps(record: Record) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Where a reading is missing, half a second in seven, and which gap it is, shape (n,) each."""
    return record.time % EVERY_S < GAP_S, (record.time // EVERY_S).astype(np.intp)


def _missing(record: Record) -> Record:
    """Torque and speed by turns are not told."""
    gone, which = _gaps(record)
    return record._replace(
        motor_torque=np.where(gone & (which % 2 == 0), np.nan, record.motor_torque),
        motor_speed=np.where(gone & (which % 2 == 1), np.nan, record.motor_speed),
    )


def _stuck(record: Record) -> Record:
    """The torque reading stays where it is."""
    gone, _ = _gaps(record)
    last = np.maximum.accumulate(np.where(gone, 0, np.arange(len(gone))))
    return record._replace(motor_torque=record.motor_torque[last])


def _repeated(record: Record) -> Record:
    """Both channels are read at 10 Hz, and each reading is told ten times."""
    now = np.arange(len(record.time))
    read = now - now % 10
    return record._replace(motor_torque=record.motor_torque[read], motor_speed=record.motor_speed[read])


def _dropped(record: Record) -> Record:
    """The speed reading falls to nothing, as of a link that drops out."""
    gone, _ = _gaps(record)
    return record._replace(motor_speed=np.where(gone, 0.0, record.motor_speed))


CASES: Mapping[str, Case] = {
    **{
        f"{length}m": Case(f"{length} m", usual(length))
        for length in (150, 400, 800, 1500, 2500, 4000, 6000, 9000)
    },
    "light": Case("light top drive, 500 kg·m²", usual(2500)._replace(drive_inertia=500.0)),
    "heavy": Case("heavy top drive, 6000 kg·m²", usual(2500)._replace(drive_inertia=6000.0)),
    "tapered": Case("tapered, seven components, 3700 m", _tapered()),
    "rubbed": Case("heavy wall friction, on bottom", _heavily_rubbed()),
    "lateral": Case("a lateral, off bottom, 3040 m", _lateral()),
    "smooth": Case("smooth drilling in rough rock, 1800 m", _smooth(1800)),
    "slow": Case("stick-slip of a large period, 5000 m", _slow()),
    "hard": Case("hard rock, and collars that ring, 1200 m", _hard()),
    "set-down": Case("set on bottom while turning", _set_down()),
    "swing": Case("weight on bit swings by 15% at 0.3 Hz", _smooth(2500)._replace(swing=(0.15, 0.3))),
    "steps": Case("read in steps of 100 N·m and 0.1 rpm", usual(2500), _in_steps),
    "missing": Case("torque or speed missing for 0.5 s every 7 s", usual(2500), _missing),
    "stuck": Case("torque reading stuck for 0.5 s every 7 s", usual(2500), _stuck),
    "dropped": Case("speed reading 0 for 0.5 s every 7 s", usual(2500), _dropped),
    "repeated": Case("read at 10 Hz, each reading told ten times", usual(2500), _repeated),
    "20hz": Case("measured at 20 Hz", usual(2500)._replace(rate=20.0)),
    "lab": Case("a lab rig: 5 m of wire", _lab()),
}
