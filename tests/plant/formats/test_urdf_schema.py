"""Misspelt elements of a URDF are named, with what was meant."""

from pathlib import Path

import pytest

from workbench.plant.formats.urdf_schema import note_unknown
from workbench.plant.formats.xml import parse_xml
from workbench.plant.remarks import Remarks


def remarks_on(text: str) -> list[str]:
    remarks = Remarks()
    note_unknown(Path("a.urdf"), parse_xml(text, Path("a.urdf")), remarks)
    return [f"{remark.element}: {remark.text}" for remark in remarks.found]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<link name="a"><intertial/></link>', "<intertial>: not known in URDF in <link> of link"),
        ('<link name="a"><intertial/></link>', "did you mean <inertial>?"),
        ('<joint name="j"><orign xyz="1 0 0"/></joint>', "in <joint> of joint 'j'"),
        ('<link name="a"><inertial><mas/></inertial></link>', "did you mean <mass>?"),
        ('<joint name="j"><origin xzy="1 0 0"/></joint>', "attribute xzy of <origin>"),
        ("<rotor/><rotor/>", "element <rotor>: not known in URDF; left out (2 times)"),
    ],
)
def test_a_misspelt_word_is_named_with_its_place(inner, said):
    (remark,) = remarks_on(f"<robot>{inner}</robot>")
    assert said in remark


@pytest.mark.parametrize(
    "inner",
    [
        '<gazebo reference="a"><sensor><at/></sensor><material>Gazebo/Red</material></gazebo>',
        '<properties arm="1"/>',
        '<link name="a"><drake:geometry/></link>',
        '<joint name="j"><limit effort="1"/><dynamics damping="0.0"/></joint>',
    ],
)
def test_what_is_used_or_means_nothing_is_not_noted(inner):
    assert remarks_on(f"<robot>{inner}</robot>") == []


def test_what_is_known_and_not_used_is_said():
    inner = """<gazebo reference="a"><mu1>0.9</mu1><kp>1</kp></gazebo>
      <gazebo reference="b"><mu1>0.9</mu1></gazebo><transmission><x/></transmission>
      <joint name="j"><dynamics damping="0.1" friction="0"/></joint>"""
    assert remarks_on(f"<robot>{inner}</robot>") == [
        "element <mu1> of <gazebo>: Gazebo's; not used (2 times)",
        "element <kp> of <gazebo>: Gazebo's; not used",
        "element <transmission>: ROS's, of control; not used",
        "element <dynamics> of <joint>: a rotor's lag is that of its motor, and no other joint "
        "moves; not used",
    ]


def test_a_strangers_thousand_words_are_not_all_repeated():
    words = "".join(f"<w{i}/>" for i in range(1000))
    assert len(remarks_on(f"<robot>{words}</robot>")) == 50
