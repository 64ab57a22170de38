"""Opening, stroke and pad positions from descriptions of grippers, against the kinematics of MuJoCo, if installed."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import tactus

mujoco = pytest.importorskip("mujoco", reason="MuJoCo (pip install mujoco) is the reference for kinematics")

MASS = '<inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>'
WEIGHT = '<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
TETRAHEDRON = "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


class Hand(NamedTuple):
    """Description of a hand: its files, bodies of hand and pads, and joint positions of the open and closed hand."""

    files: dict[str, str]
    hand: str
    pads: tuple[str, str]
    open: dict[str, float]
    closed: dict[str, float]


def urdf(palm: str, joints: str, *pads: tuple[str, str, str], more: str = "", compiler: str = "") -> str:
    """Returns a URDF of two fingers that slide on a palm, which is mounted on a base."""
    links = "".join(f'<link name="{link}">{WEIGHT}{more}</link>' for link in ("base", "palm", "left", "right"))
    pad = '<link name="{0}">' + WEIGHT + '</link><joint name="fix_{0}" type="fixed"><parent link="{1}"/><child link="{0}"/>{2}</joint>'
    return f"""<robot name="g"><mujoco><compiler fusestatic="false" {compiler}/></mujoco>{links}
<joint name="mount" type="fixed"><parent link="base"/><child link="palm"/>{palm}</joint>
{joints}{"".join(pad.format(*p) for p in pads)}</robot>"""


def slide(name: str, child: str, inside: str) -> str:
    return f'<joint name="{name}" type="prismatic"><parent link="palm"/><child link="{child}"/>{inside}</joint>'


def franka_urdf() -> Hand:
    """Franka hand, mounted at 45 degrees; the second finger is rotated by 3.14159 rad and mimics the first."""
    limit = '<limit effort="100" lower="0.0" upper="0.04" velocity="0.2"/>'
    origin = '<origin rpy="0 0 {}" xyz="0 0 0.0584"/><axis xyz="0 1 0"/>'
    right = origin.format("3.14159") + limit + '<mimic joint="finger_joint1"/>'
    joints = slide("finger_joint1", "left", origin.format("0") + limit) + slide("finger_joint2", "right", right)
    pads = [(f"{side}_pad", side, '<origin xyz="0 -0.005 0.0544"/>') for side in ("left", "right")]
    text = urdf('<origin rpy="0 0.3 -0.785398163397" xyz="0 0 0.107"/>', joints, *pads)
    names = ("finger_joint1", "finger_joint2")
    return Hand({"f.urdf": text}, "palm", ("left_pad", "right_pad"), dict.fromkeys(names, 0.04), dict.fromkeys(names, 0.0))


def franka_mjcf() -> Hand:
    """Franka hand as MJCF: default classes, an equality constraint of both joints, quaternions."""
    text = f"""<mujoco><compiler angle="radian" autolimits="true"/>
<default><default class="panda"><joint axis="0 0 1" range="-2.8 2.8"/>
  <default class="finger"><joint axis="0 1 0" type="slide" range="0 0.04"/></default></default></default>
<worldbody><body name="link7" childclass="panda" pos="0.1 0 0.4">{MASS}<joint name="joint7"/>
 <body name="hand" pos="0 0 0.107" quat="0.9238795 0 0 -0.3826834">{MASS}
  <body name="left_finger" pos="0 0 0.0584">{MASS}<joint name="finger_joint1" class="finger"/><site name="left" pos="0 -0.005 0.0544"/></body>
  <body name="right_finger" pos="0 0 0.0584" quat="0 0 0 1">{MASS}<joint name="finger_joint2" class="finger"/>
   <site name="right" pos="0 -0.005 0.0544"/></body></body></body></worldbody>
<equality><joint joint1="finger_joint1" joint2="finger_joint2"/></equality></mujoco>"""
    names = ("finger_joint1", "finger_joint2")
    return Hand({"f.xml": text}, "hand", ("left", "right"), dict.fromkeys(names, 0.04), dict.fromkeys(names, 0.0))


def robotiq() -> Hand:
    """Robotiq 2F-85 with prismatic joints for the linkage: both fingers mimic a revolute motor, 0.8 rad closed."""
    motor = '<link name="crank">' + WEIGHT + '</link><joint name="finger_joint" type="revolute"><parent link="palm"/><child link="crank"/>'
    motor += '<axis xyz="1 0 0"/><limit lower="0" upper="0.8" velocity="2" effort="1000"/></joint>'
    mimic = '<mimic joint="finger_joint" multiplier="{}" offset="{}"/>'
    left = '<origin xyz="0 -0.0425 0.13"/><axis xyz="0 1 0"/>' + mimic.format("0.053125", "0")
    right = '<origin xyz="0 0 0.13"/><axis xyz="0 1 0"/>' + mimic.format("-0.053125", "0.0425")
    joints = motor + slide("left_knuckle", "left", left) + slide("right_knuckle", "right", right)
    pads = [(f"{side}_pad", side, '<origin xyz="0 0 0.01"/>') for side in ("left", "right")]
    closed = {"left_knuckle": 0.0425, "right_knuckle": 0.0}
    text = urdf('<origin xyz="0 0 0.2"/>', joints, *pads)
    return Hand({"r.urdf": text}, "palm", ("left_pad", "right_pad"), {"left_knuckle": 0.0, "right_knuckle": 0.0425}, closed)


def piper() -> Hand:
    """Piper hand: quaternions of six digits."""
    finger = '<body name="link{0}" pos="0 0 0.13503" quat="{1}">' + MASS
    finger += '<joint name="joint{0}" axis="0 0 {2}" type="slide" range="{3}"/><site name="pad{0}" pos="0 {4} 0"/></body>'
    left = finger.format(7, "1.89468e-08 1.89469e-08 0.707108 0.707105", "1", "0 0.035", "-0.03")
    right = finger.format(8, "1.89468e-08 -1.89469e-08 -0.707108 0.707105", "-1", "-0.035 0", "0.03")
    text = f'<mujoco><compiler angle="radian"/><worldbody><body name="link6" euler="0.1 0.2 0.3">{MASS}{left}{right}</body></worldbody></mujoco>'
    return Hand({"p.xml": text}, "link6", ("pad7", "pad8"), {"joint7": 0.035, "joint8": -0.035}, {"joint7": 0.0, "joint8": 0.0})


def package() -> Hand:
    """ROS package: shapes by `package://`, fingers rotated by 1.5708 rad."""
    shape = '<collision><geometry><mesh filename="package://tips_description/meshes/tip.obj"/></geometry></collision>'
    inside = '<origin rpy="1.5708 0 0" xyz="0 0 0.06"/><axis xyz="0 0 {}"/><limit lower="0.005" upper="0.045" effort="1" velocity="1"/>'
    joints = slide("l", "left", inside.format(-1)) + slide("r", "right", inside.format(1))
    pads = [(f"{side}_pad", side, '<origin xyz="0 0.05 0"/>') for side in ("left", "right")]
    text = urdf("", joints, *pads, more=shape, compiler='meshdir="../meshes" strippath="true"')
    files = {"tips_description/urdf/p.urdf": text, "tips_description/meshes/tip.obj": TETRAHEDRON}
    return Hand(files, "palm", ("left_pad", "right_pad"), {"l": 0.045, "r": 0.045}, {"l": 0.005, "r": 0.005})


def included() -> Hand:
    """MJCF of several files, nested includes (settings and classes, robot, fingers), Euler angles zyx in degrees."""
    main = '<mujoco><include file="parts/settings.xml"/><include file="parts/robot.xml"/></mujoco>'
    settings = '<mujocoinclude><compiler eulerseq="zyx"/><default><default class="f"><joint type="slide" axis="1 0 0" range="0 0.025"/>'
    settings += '<site pos="-0.004 0.001 0.07" euler="0 0 5"/></default></default></mujocoinclude>'
    robot = f'<mujoco><worldbody><body name="palm" euler="30 20 10" childclass="f">{MASS}<include file="parts/fingers.xml"/></body></worldbody></mujoco>'
    fingers = f'<mujocoinclude><body pos="0 0 0.05">{MASS}<joint name="l"/><site name="a"/></body>'
    fingers += f'<body pos="0 0.002 0.05" euler="180 0 0">{MASS}<joint name="r"/><site name="b"/></body></mujocoinclude>'
    files = {"m.xml": main, "parts/settings.xml": settings, "parts/robot.xml": robot, "parts/fingers.xml": fingers}
    return Hand(files, "palm", ("a", "b"), {"l": 0.025, "r": 0.025}, {"l": 0.0, "r": 0.0})


def attached() -> Hand:
    """Hand attached to an arm within a frame, with a joint of nonzero reference position."""
    arm = f'<mujoco><asset><model name="h" file="hand/hand.xml"/></asset><worldbody><body name="arm" pos="0 0 1">{MASS}<joint axis="0 1 0"/>'
    arm += '<frame pos="0 0 0.1" zaxis="1 0 1"><attach model="h" body="palm" prefix="g_"/></frame></body></worldbody></mujoco>'
    finger = '<frame xyaxes="0 1 0 -1 0 0"><body name="{0}" pos="{1} 0 0.05">' + MASS
    finger += '<joint name="{0}" type="slide" axis="{2} 0 0" range="0 0.03" ref="{3}"/><site name="{0}" pos="0 0 0.06"/></body></frame>'
    hand = f'<mujoco><worldbody><body name="palm" axisangle="0 0 1 40">{MASS}{finger.format("l", "0.03", "-1", "0")}'
    hand += f'{finger.format("r", "-0.02", "1", "0.01")}</body></worldbody></mujoco>'
    return Hand({"arm.xml": arm, "hand/hand.xml": hand}, "g_palm", ("site:g_l", "site:g_r"), {"g_l": 0.0, "g_r": 0.0}, {"g_l": 0.03, "g_r": 0.03})


def schunk() -> Hand:
    """Schunk WSG 50: fingers that close along x, with ranges of either sign and a rotation of 3.1416 rad."""
    left = '<origin xyz="0 0 0.0669"/><axis xyz="1 0 0"/><limit lower="-0.055" upper="-0.002" effort="80" velocity="0.42"/>'
    right = '<origin xyz="0 0 0.0669" rpy="0 0 3.1416"/><axis xyz="-1 0 0"/><limit lower="0.002" upper="0.055" effort="80" velocity="0.42"/>'
    joints = slide("l", "left", left) + slide("r", "right", right)
    pads = ("left_pad", "left", '<origin xyz="0 0 0.03"/>'), ("right_pad", "right", '<origin xyz="0 0 0.03"/>')
    return Hand({"w.urdf": urdf("", joints, *pads)}, "palm", ("left_pad", "right_pad"), {"l": -0.055, "r": 0.055}, {"l": -0.002, "r": 0.002})


def pads_in_hand(model, of: Hand, positions: dict[str, float]) -> np.ndarray:
    """Returns the centres of both pads in the hand frame by MuJoCo, (2, 3), m."""
    data = mujoco.MjData(model)
    for name, position in positions.items():
        data.qpos[model.joint(name).qposadr[0]] = position
    mujoco.mj_kinematics(model, data)
    hand = data.body(of.hand)
    sites = {model.site(i).name for i in range(model.nsite)}
    pads = [name.removeprefix("site:") for name in of.pads]
    places = np.array([data.site(name).xpos if name in sites else data.body(name).xpos for name in pads])
    return (places - hand.xpos) @ hand.xmat.reshape(3, 3)


@pytest.mark.parametrize("make", [franka_urdf, franka_mjcf, robotiq, piper, package, included, attached, schunk])
def test_opening_stroke_and_places_of_the_pads_are_those_of_mujoco(make, tmp_path: Path):
    of = make()
    for name, text in of.files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    main = tmp_path / next(iter(of.files))
    text = f"""(object: (shape: Sphere(radius: 0.01)), loading: Squeeze(force: 5, frames: 1),
        gripper: (robot: (path: "{main}", hand: "{of.hand}", pads: ("{of.pads[0]}", "{of.pads[1]}")), pads: GelSightMini(spacing: 8e-3)))"""
    (tmp_path / "scene.ron").write_text(text)
    gripper = tactus.check(tmp_path / "scene.ron")["scene"]["gripper"]
    model = mujoco.MjModel.from_xml_path(str(main))
    opened, closed = (pads_in_hand(model, of, positions) for positions in (of.open, of.closed))
    travel = closed - opened
    strokes = np.linalg.norm(travel, axis=1)
    closing, approach = travel[0] / strokes[0], np.array([0.0, 0.0, 1.0])
    middle = opened.mean(axis=0)
    bar = 1e-5
    assert np.allclose(travel[1] / strokes[1], -closing, atol=2e-3), "the fingers close on each other"
    assert gripper["opening"] == pytest.approx((opened[1] - opened[0]) @ closing, abs=bar)
    assert np.allclose(strokes, gripper["stroke"], atol=bar)
    assert gripper["placement"]["z"] == pytest.approx(middle @ approach, abs=bar)
    assert gripper["placement"]["y"] == pytest.approx(middle @ np.cross(approach, closing), abs=bar)
