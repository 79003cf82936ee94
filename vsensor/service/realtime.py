"""What the system is asked for so that the loop wakes on time, and what it granted.

Scheduling and processors are those of the calling thread alone: threads and processes that are already
there keep theirs, and those that it starts later are ordinary ones (SCHED_RESET_ON_FORK). Locked memory and
processors that are kept awake are the whole program's, for as long as it runs.
"""

import contextlib
import ctypes
import gc
import os
import resource
import sys
from collections.abc import Callable, Collection
from pathlib import Path
from typing import NamedTuple

from vsensor.config import Loop
from vsensor.errors import ConfigError
from vsensor.service.awake import WakeRequest

SWITCH_INTERVAL_S = 2e-4
"""How soon another thread of Python must yield to the loop: the default 5 ms is half a tick at 100 Hz."""

_PR_SET_TIMERSLACK = 29  # linux/prctl.h
_LOCK_ALL = 1 | 2 | 4  # MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT, linux/mman.h: what is touched stays in memory
_CAP_IPC_LOCK, _CAP_SYS_NICE = 14, 23  # linux/capability.h
_NEEDS_MEMORY = "needs CAP_IPC_LOCK, or no limit (ulimit -l unlimited; systemd: LimitMEMLOCK=infinity)"
_IN_SPITE = (
    "and yet it is refused: by its control group, which has no real-time run time (kernels with "
    "CONFIG_RT_GROUP_SCHED: boot with rt_group_sched=0, or sysctl kernel.sched_rt_runtime_us=-1), "
    "or by a filter of system calls (systemd: RestrictRealtime=, SystemCallFilter=)"
)

_wake_request = WakeRequest()


class Achieved(NamedTuple):
    """What the loop's thread has, whatever was asked for."""

    asked: str
    """off, prefer or require."""
    scheduling: str
    """SCHED_OTHER, or SCHED_FIFO and the priority."""
    processors: tuple[int, ...]
    """On which it may run,"""
    others: tuple[int, ...]
    """and on which all else of this program may."""
    memory_locked: bool
    kept_awake: bool
    """Whether processors are kept from their idle states."""
    switch_interval_s: float
    """How soon another thread of Python yields to the loop."""
    garbage_frozen: int
    """Objects that stand since the start, which no collection of garbage walks over."""
    refused: tuple[str, ...] = ()
    """What was not granted, and what would help."""

    @property
    def words(self) -> str:
        """All of it in one line."""
        memory = "locked" if self.memory_locked else "not locked"
        where = ", ".join(map(str, self.processors))
        awake = ", processors kept awake" if self.kept_awake else ""
        return f"real-time {self.asked}: {self.scheduling} on processor {where}, memory {memory}{awake}"

    def as_metadata(self) -> dict[str, str]:
        """As text, for a session's metadata."""
        return {
            "realtime": self.asked,
            "scheduling": self.scheduling,
            "loop_processors": ",".join(map(str, self.processors)),
            "memory_locked": "yes" if self.memory_locked else "no",
            "kept_awake": "yes" if self.kept_awake else "no",
            "switch_interval_s": f"{self.switch_interval_s:g}",
            "garbage_frozen": str(self.garbage_frozen),
        }


def achieve(loop: Loop, others: Collection[int] = ()) -> Achieved:
    """Ask for what the configuration wants, for the calling thread. Call once all else has been started.

    Asked again, give the `others` of before. Raises ConfigError where `require` is not granted, with what
    would help: no other start with the same configuration and limits will have it.
    """
    if others:
        _step_back(others)
    others = tuple(sorted(os.sched_getaffinity(0)))
    asked: tuple[Callable[[Loop], str], ...] = (_take_priority, _lock_memory, _take_processors, _stay_awake)
    told = [ask(loop) for ask in asked] if loop.realtime != "off" else []
    refused = tuple(words for words in told if words)
    if refused and loop.realtime == "require":
        raise ConfigError(
            'loop.realtime = "require" is not granted:\n' + "\n".join(f"  {r}" for r in refused)
        )
    locked = loop.realtime != "off" and not told[1]
    return Achieved(
        loop.realtime,
        _scheduling(),
        tuple(sorted(os.sched_getaffinity(0))),
        others,
        locked,
        _wake_request.stands,
        sys.getswitchinterval(),
        gc.get_freeze_count(),
        refused,
    )


def _step_back(processors: Collection[int]) -> None:
    """As before anything was asked for."""
    with contextlib.suppress(OSError):
        os.sched_setaffinity(0, processors)
    with contextlib.suppress(OSError):
        # Without CAP_SYS_NICE a thread may give back its priority, but not that its children have none.
        os.sched_setscheduler(0, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
    _libc().munlockall()
    _wake_request.withdraw()


def settle() -> None:
    """What needs nobody's leave: exact timers, no long waits for other threads, less to collect."""
    # By default the kernel may wake an ordinary thread 50 µs late, to save power.
    _libc().prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1), 0, 0, 0)
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    # What was made to start with stays: a full collection would walk over it for a tenth of a second.
    gc.collect()
    gc.freeze()


def _take_priority(loop: Loop) -> str:
    try:
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(loop.priority))
    except OSError as error:
        return f"SCHED_FIFO {loop.priority}: {error.strerror}: {_why_no_priority(loop.priority)}"
    return ""


def _why_no_priority(priority: int) -> str:
    limit, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
    if limit >= priority or limit == resource.RLIM_INFINITY:
        return f"the limit (ulimit -r) is high enough, {_IN_SPITE}"
    needed = f"a limit of at least {priority} (ulimit -r; systemd: LimitRTPRIO=)"
    if _is_capable(_CAP_SYS_NICE):
        return f"CAP_SYS_NICE is there, {_IN_SPITE}; or it is a user namespace's, which needs {needed}"
    return f"the limit is {limit}: needs CAP_SYS_NICE, or {needed}"


def _lock_memory(_loop: Loop) -> str:
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit != resource.RLIM_INFINITY and not _is_capable(_CAP_IPC_LOCK):
        # With a limit the lock would be granted now, and an allocation refused once it is reached.
        return f"memory lock: {limit >> 10} KiB are allowed: {_NEEDS_MEMORY}"
    if _libc().mlockall(_LOCK_ALL):
        # In a user namespace the capability is there, and counts for nothing.
        return f"memory lock: {os.strerror(ctypes.get_errno())}: {_NEEDS_MEMORY}"
    return ""


def _take_processors(loop: Loop) -> str:
    if not loop.processors:
        return ""
    asked = f"processors {list(loop.processors)}"
    here = (
        f"this machine has {os.cpu_count()}, from 0 on; this program may have fewer (systemd: AllowedCPUs=)"
    )
    try:
        os.sched_setaffinity(0, loop.processors)
    except OSError as error:
        return f"{asked}: {error.strerror}: {here}"
    # The kernel passes over those that are not there, as long as one is.
    if (got := os.sched_getaffinity(0)) != set(loop.processors):
        return f"{asked}: only {sorted(got)}: {here}"
    return ""


def _stay_awake(loop: Loop) -> str:
    return _wake_request.make() if loop.stay_awake else ""


def _scheduling() -> str:
    if os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO:
        return f"SCHED_FIFO {os.sched_getparam(0).sched_priority}"
    return "SCHED_OTHER"


def _is_capable(capability: int) -> bool:
    status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
    (effective,) = (line for line in status.splitlines() if line.startswith("CapEff:"))
    return bool(int(effective.split()[1], 16) >> capability & 1)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)
