"""A simple body for any armature: a mannequin of rounded volumes that follow the bones."""

import bpy
import numpy as np

from ...core.motion.joint_roles import JointRole
from .body_shapes import Part, capsule, egg, joined, slab, trunk
from .materials import own_material, remove_unused_materials
from .rig import bind_rig
from .versions import node_tree

BODY_PROPERTY = "wayfarer_body"
"""Custom property of the mesh objects that :func:`add_body` makes."""

_MATERIALS = {"Wayfarer Body": (0.80, 0.24, 0.05), "Wayfarer Body Light": (0.80, 0.74, 0.66)}
_ORANGE, _LIGHT = 0, 1

_LEG_SHARE = 0.485
"""Length of thigh and shin together as part of a person's height."""

# Radii as parts of the height: at the bone's head and at its tail.
_LIMB_RADII = {
    JointRole.THIGH: (0.047, 0.033),
    JointRole.SHIN: (0.034, 0.021),
    JointRole.UPPER_ARM: (0.030, 0.022),
    JointRole.LOWER_ARM: (0.023, 0.015),
}


def add_body(armature_object) -> bpy.types.Object | None:
    """A mesh object that makes an armature visible, moved by it through vertex groups named after the bones.

    Where the bones' names tell a humanoid, it is a mannequin: lofted trunk, tapered limbs, an egg for a
    head, flat hands and feet, in proportion to the length of the legs. Other bones become tapered rods, as
    long as they deform. Bones too short to be seen are left out; if that leaves none, as in a chain of very many, there
    is no body: None. The object is parented to the armature, and linked to the same collections.

    Raises ClipError for the reasons of :func:`bind_rig`.
    """
    parts = _Mannequin(armature_object).parts()
    if not parts:
        return None
    vertices, faces, materials, weights = joined(parts)
    mesh = bpy.data.meshes.new(f"{armature_object.name} Body")
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("material_index", materials.astype(np.int32))
    mesh.shade_smooth()
    for name, color in _MATERIALS.items():
        mesh.materials.append(_material(name, color))
    obj = bpy.data.objects.new(mesh.name, mesh)
    obj[BODY_PROPERTY] = True
    for bone, shares in weights.items():
        group = obj.vertex_groups.new(name=bone)
        for weight in np.unique(shares[shares > 0]):
            group.add(np.flatnonzero(shares == weight).tolist(), float(weight), "REPLACE")
    for collection in armature_object.users_collection:
        collection.objects.link(obj)
    obj.parent = armature_object
    obj.modifiers.new("Armature", "ARMATURE").object = armature_object
    # Selecting the body of a character is rarely what is meant.
    obj.hide_select = True
    return obj


class _Mannequin:
    """Decides for each bone which volume it gets; all positions are in armature space."""

    def __init__(self, armature_object):
        skeleton = bind_rig(armature_object).skeleton
        bones = armature_object.data.bones
        self.skeleton, self.names, self.parents = skeleton, skeleton.names, np.asarray(skeleton.parents)
        self.heads = np.array([bones[name].head_local for name in self.names])
        self.tails = np.array([bones[name].tail_local for name in self.names])
        self.deforms = [bones[name].use_deform for name in self.names]
        up = np.array(armature_object.matrix_world.to_3x3().inverted())[:, 2]
        self.up = up / np.linalg.norm(up)
        roles = skeleton.roles
        self.joint = {key: joints[0] for key, joints in roles.items()}
        self.spine = roles.get((JointRole.SPINE, ""), ())
        limbs = [(role, side) for role in _LIMB_RADII for side in ("left", "right")]
        self.is_humanoid = all(limb in self.joint for limb in limbs) and len(self.spine) > 0
        if self.is_humanoid:
            thigh, shin = self.joint[JointRole.THIGH, "left"], self.joint[JointRole.SHIN, "left"]
            leg = np.linalg.norm(self.heads[shin] - self.heads[thigh])
            leg += np.linalg.norm(self._end(shin) - self.heads[shin])
            self.height = float(leg / _LEG_SHARE)
            across = self.heads[thigh] - self.heads[self.joint[JointRole.THIGH, "right"]]
        else:
            self.height = float(np.ptp(np.concatenate([self.heads, self.tails]) @ self.up))
            across = np.array([1.0, 0.0, 0.0])
        across = across - (across @ self.up) * self.up
        if np.linalg.norm(across) < 1e-6 * max(self.height, 1e-6):
            across = np.cross(self.up, [0.0, 1.0, 0.0] if abs(self.up[1]) < 0.9 else [0.0, 0.0, 1.0])
        self.left = across / np.linalg.norm(across)
        self.forward = np.cross(self.left, self.up)

    def parts(self) -> list[Part]:
        parts, done = [], set()
        if self.is_humanoid:
            parts.append(self._trunk())
            done |= {0, *self.spine}
            for (role, side), joint in self.joint.items():
                if role in _LIMB_RADII:
                    parts.append(self._limb(joint, _LIMB_RADII[role]))
                    done.add(joint)
                if role is JointRole.FOOT:
                    parts += self._foot(joint, self.joint.get((JointRole.TOES, side)))
                    done |= {joint, *self.skeleton.descendants(joint)}
                if role is JointRole.LOWER_ARM:
                    hands = np.flatnonzero(self.parents == joint)
                    if len(hands):
                        parts.append(self._hand(int(hands[0]), joint))
                    done |= set(self.skeleton.descendants(joint))
            if (JointRole.HEAD, "") in self.joint:
                head = self.joint[JointRole.HEAD, ""]
                parts += self._head(head)
                done |= {head, *self.skeleton.descendants(head), *self._between(self.spine[-1], head)}
            for side in ("left", "right"):
                arm, leg = self.joint[JointRole.UPPER_ARM, side], self.joint[JointRole.THIGH, side]
                collars = self._between(max(self.spine), arm)
                for collar in collars[-1:]:
                    radius = 0.025 * self.height
                    # From within the chest, not from the spine, where it would stand out of the back.
                    start = self.heads[collar] + 0.3 * (self.heads[arm] - self.heads[collar])
                    parts.append(capsule(self.names[collar], start, self.heads[arm], radius, radius, _ORANGE))
                done |= {*collars, *self._between(0, leg)}
        for joint, name in enumerate(self.names):
            length = float(np.linalg.norm(self.tails[joint] - self.heads[joint]))
            if joint not in done and self.deforms[joint] and length > 0.01 * self.height:
                radius = min(0.12 * length, 0.03 * self.height)
                parts.append(capsule(name, self.heads[joint], self.tails[joint], radius, 0.6 * radius, _ORANGE))
        return parts

    def _trunk(self) -> Part:
        """From the crotch to the base of the neck, one tube that bends at the joints of the spine."""
        hips = (self.heads[self.joint[JointRole.THIGH, "left"]] + self._right_hip()) / 2
        neck = self._end(self.spine[-1])
        bones, stations = [0, *self.spine], [hips - 0.035 * self.height * self.up]
        stations += [self.heads[joint] for joint in self.spine] + [neck]
        # Joints that lie in the hips add nothing but a fold.
        rise = np.array(stations) @ self.up
        kept = [0] + [k for k in range(1, len(bones)) if rise[k] > rise[0] + 0.06 * self.height] + [len(bones)]
        names = [self.names[bones[k]] for k in kept[:-1]]
        return trunk(names, np.array(stations)[kept], self.left, self.up, self.height, _ORANGE)

    def _right_hip(self) -> np.ndarray:
        return self.heads[self.joint[JointRole.THIGH, "right"]]

    def _limb(self, joint: int, radii: tuple[float, float]) -> Part:
        first, last = np.multiply(radii, self.height)
        return capsule(self.names[joint], self.heads[joint], self._end(joint), first, last, _ORANGE)

    def _foot(self, ankle: int, toes: int | None) -> list[Part]:
        """Heel to ball, and the toes as a piece of their own where there is a bone for them."""
        h = self.height
        ball = self.heads[toes] if toes is not None and toes != ankle else self.tails[ankle]
        along = ball - self.heads[ankle]
        along = along - (along @ self.up) * self.up
        length = np.linalg.norm(along)
        ahead = along / length if length > 0.02 * h else self.forward
        # The sole lies where the sample's does: CMU's toes rest lower than their feet.
        sole = min(self.heads[ankle] @ self.up - 0.035 * h, ball @ self.up - 0.012 * h)
        floor = self.heads[ankle] + (sole - self.heads[ankle] @ self.up) * self.up
        heel = floor - 0.035 * h * ahead
        front = floor + max(length, 0.06 * h) * ahead
        side = np.cross(self.up, ahead)
        parts = [
            slab(self.names[ankle], heel, front, side, self.up, (0.019, 0.027), (0.046, 0.026), h, _LIGHT),
        ]
        if toes is not None and toes != ankle:
            tip = front + max(np.linalg.norm(self.tails[toes] - self.heads[toes]), 0.035 * h) * ahead
            start = front - 0.012 * h * ahead
            parts.append(slab(self.names[toes], start, tip, side, self.up, (0.027, 0.022), (0.024, 0.014), h, _LIGHT))
        return parts

    def _hand(self, hand: int, forearm: int) -> Part:
        """A flat paddle from the wrist on, thumb side forward."""
        # Where the wrist lies in the elbow, or the arm points ahead, another direction has to do.
        along = _unit(self.heads[hand] - self.heads[forearm], self.left)
        wrist = self.heads[hand]
        side = _unit(self.forward - (self.forward @ along) * along, self.left - (self.left @ along) * along)
        start, tip = wrist - 0.012 * self.height * along, wrist + 0.095 * self.height * along
        thin = np.cross(along, side)
        return slab(
            self.names[hand], start, tip, side, thin, (0.016, 0.017), (0.018, 0.012), self.height, _LIGHT, centred=True
        )

    def _head(self, head: int) -> list[Part]:
        """A neck from the trunk's end, and an egg upon it."""
        h = self.height
        base = self._end(self.spine[-1])
        necks = self._between(self.spine[-1], head)
        neck = necks[-1] if necks else head
        centre = self.heads[head] + 0.052 * h * self.up + 0.012 * h * self.forward
        return [
            capsule(self.names[neck], base - 0.01 * h * self.up, centre, 0.034 * h, 0.030 * h, _LIGHT),
            egg(self.names[head], centre, self.left, self.forward, self.up, (0.043 * h, 0.052 * h, 0.066 * h), _LIGHT),
        ]

    def _end(self, joint: int) -> np.ndarray:
        """Return the place where a bone ends: at the joint that carries on its chain, or at its tail."""
        children = [
            child
            for child in np.flatnonzero(self.parents == joint)
            if np.linalg.norm(self.heads[child] - self.heads[joint]) > 0.01 * getattr(self, "height", 0.0)
        ]
        if joint in self.spine and (JointRole.HEAD, "") in self.joint:
            path = self._between(joint, self.joint[JointRole.HEAD, ""]) + [self.joint[JointRole.HEAD, ""]]
            return self.heads[path[0]]
        return self.heads[children[0]] if len(children) else self.tails[joint]

    def _between(self, above: int, below: int) -> list[int]:
        """Joints between two of a chain, both excluded, from the top down; up to the root if it is not one chain."""
        found = []
        joint = int(self.parents[below])
        while joint not in (above, -1) and joint not in self.spine and joint != 0:
            found.append(joint)
            joint = int(self.parents[joint])
        return found[::-1]


def _unit(vector: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """The direction of a (3,) vector, or of another where it is as good as none."""
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-6 else otherwise / np.linalg.norm(otherwise)


def remove_body(body) -> None:
    """Remove what :func:`add_body` made, with its mesh and materials unless others use them."""
    mesh = body.data
    bpy.data.objects.remove(body)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
    remove_unused_materials(_MATERIALS)


def _material(name: str, color: tuple[float, float, float]):
    def furnish(material) -> None:
        material.diffuse_color = (*color, 1.0)
        material.roughness = 0.6
        shader = node_tree(material).nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*color, 1.0)
        shader.inputs["Roughness"].default_value = 0.5

    return own_material(name, furnish)
