"""A small BVH reader, so that the core's tests can run on recorded motions without Blender.

It shares no code with the product: a Blender test compares it with Blender's importer and the bridge.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from core.motion.clip import MotionClip
from core.motion.skeleton import Skeleton

CMU_UNIT = 0.056444  # metres per length unit in the BVH files of the CMU motion capture database

Y_UP_TO_Z_UP = Rotation.from_euler("X", 90, degrees=True)  # BVH's Y becomes Z, its Z becomes -Y


def read_bvh(path, scale: float = CMU_UNIT, drop_first: int = 0) -> MotionClip:
    """The motion of a BVH file, in the core's conventions (Z up, metres); end sites are left out.

    ``scale`` is the length of one BVH unit in metres; the first ``drop_first`` frames are skipped.
    """
    hierarchy, motion = Path(path).read_text().split("MOTION", 1)
    names, parents, offsets, channels = _read_hierarchy(hierarchy.split())
    header, frame_time, samples = motion.strip().split("\n", 2)
    values = np.array(samples.split(), dtype=float).reshape(-1, sum(map(len, channels)))
    if len(values) != int(header.split()[-1]):
        raise ValueError(f"{path}: {len(values)} frames instead of the {header.split()[-1]} announced.")
    values = values[drop_first:]

    rotations = np.empty((len(values), len(names), 4))
    translations = np.tile(offsets, (len(values), 1, 1))
    column = 0
    for joint, joint_channels in enumerate(channels):
        order, angles = "", []
        for channel in joint_channels:
            if channel.endswith("position"):
                translations[:, joint, "XYZ".index(channel[0])] = values[:, column]
            else:
                order += channel[0]
                angles.append(values[:, column])
            column += 1
        rotation = Rotation.from_euler(order, np.column_stack(angles), degrees=True)
        if joint == 0:
            rotation = Y_UP_TO_Z_UP * rotation
        rotations[:, joint] = rotation.as_quat(scalar_first=True)
    translations[:, 0] = Y_UP_TO_Z_UP.apply(translations[:, 0])

    rest_rotations = np.tile([1.0, 0, 0, 0], (len(names), 1))
    rest_rotations[0] = Y_UP_TO_Z_UP.as_quat(scalar_first=True)
    rest_translations = offsets.copy()
    rest_translations[0] = Y_UP_TO_Z_UP.apply(offsets[0])
    left = offsets[names.index("LeftUpLeg")] - offsets[names.index("RightUpLeg")]
    forward = np.cross(left, [0, 1, 0])  # the legs' parents have no offset in these files; Y is up
    forward = forward / np.linalg.norm(forward)
    return MotionClip(
        name=Path(path).stem,
        skeleton=Skeleton(tuple(names), np.array(parents), rest_rotations, rest_translations * scale, forward),
        frame_rate=round(1 / float(frame_time.split()[-1]), 2),
        rotations=rotations,
        translations=translations * scale,
        first_frame=float(drop_first),
    )


def _read_hierarchy(tokens):
    names, parents, offsets, channels, open_joints = [], [], [], [], []
    at_end_site = False
    for position, token in enumerate(tokens):
        if token in ("ROOT", "JOINT"):
            names.append(tokens[position + 1])
            parents.append(open_joints[-1] if open_joints else -1)
            open_joints.append(len(names) - 1)
        elif token == "End":
            at_end_site = True
        elif token == "OFFSET" and not at_end_site:
            offsets.append([float(value) for value in tokens[position + 1 : position + 4]])
        elif token == "CHANNELS":
            channels.append(tokens[position + 2 : position + 2 + int(tokens[position + 1])])
        elif token == "}":
            if at_end_site:
                at_end_site = False
            else:
                open_joints.pop()
    return names, parents, np.array(offsets), channels
