"""Names of the arrays that `chain.c` reads, in order, and the C header made of them."""

from __future__ import annotations

import numpy as np

JOINT: dict[str, float] = {
    # What a joint does by itself.
    **{"viscous": 0, "quadratic": 0, "coulomb": 0, "stiction": 0, "stribeck": 1},
    **{"load_c": 0, "load_k": 0, "patch": 0, "patch_depth": 0, "patch_n": 0, "patch_phase": 0},
    **{"stiffness": 0, "rest": 0, "cog": 0, "cog_n": 0, "cog_phase": 0, "loop": 0, "loop_way": 1},
    **{"stop": 0, "stop_side": 0, "stop_k": 0, "stop_d": 0},
    # Its drive: 0 none, 1 torque, 2 position servo; and what is between motor and link.
    **{"drive": 0, "kp": 0, "kv": 0, "gain": 1, "delay": 0, "lag": 0, "limit": np.inf},
    **{"stall": 0, "no_load": 0, "emf": 0, "heat_rate": 0, "heat_floor": 1, "heat_level": 1},
    **{"sag": 0, "dead": 0, "rotor": 0, "split": 0, "gap": 0, "spring_k": 0, "spring_d": 0},
    # Its sensor, and the controller that tracks a path with its readings.
    **{"bias": 0, "scale": 1, "shift": 0, "count": 0, "track_p": 0, "track_d": 0, "most": np.inf},
    # Outside the vocabulary: drum, gear teeth, warm oil, detent, friction with memory, supply.
    **{"drum": 0, "tooth": 0, "tooth_n": 0, "warm": 0, "warm_rate": 0, "detent": 0, "detent_n": 0},
    **{"memory": 0, "memory_time": 1, "supply": 0, "supply_rate": 0},
}
"""Figures of each joint, with the values at which they do nothing."""

BODY: dict[str, float] = {
    **dict.fromkeys(("mass", "cx", "cy", "cz", "fx", "fy", "fz"), 0),
    **{f"linear{axis}": 0 for axis in ("", "_y", "_z", "_rx", "_ry", "_rz")},
    **{f"quadratic{axis}": 0 for axis in ("", "_y", "_z", "_rx", "_ry", "_rz")},
    **{f"added{axis}": 0 for axis in ("", "_y", "_z", "_rx", "_ry", "_rz")},
    **dict.fromkeys(("buoyancy", "thrust", "tether_k", "tether_length"), 0),
    **dict.fromkeys(("anchor", "anchor_y", "anchor_z", "push_start", "push_end"), 0),
    **dict.fromkeys(("push", "push_y", "push_z", "spin"), 0),
}
"""Figures of each body; (fx, fy, fz) is the point at which fluid and tether act."""

STATES = (
    *("q", "v", "before", "rotor_q", "rotor_v", "rotor_before"),
    *("lag", "heat", "loop", "warm", "memory", "rub"),
)
"""State of each joint: motion, motor side, what laws remember, and the last dry friction."""

JOINT_ROW = {name: row for row, name in enumerate(JOINT)}
BODY_ROW = {name: row for row, name in enumerate(BODY)}
STATE_ROW = {name: row for row, name in enumerate(STATES)}


def header() -> str:
    """Return the definitions that stand in front of `chain.c`."""
    lines = [f"#define J_{name} {row}" for name, row in JOINT_ROW.items()]
    lines += [f"#define B_{name} {row}" for name, row in BODY_ROW.items()]
    lines += [f"#define S_{name} {row}" for name, row in STATE_ROW.items()]
    lines += [f"#define N_JOINTS {len(JOINT)}", f"#define N_STATES {len(STATES)}"]
    return "\n".join([*lines, ""])
