"""Files too large for MuJoCo to be done with in time: counted, and refused before it begins."""

from pathlib import Path

import mujoco
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import read_model
from simsat.mjcf.refusals.size import Elements, too_large
from simsat.mjcf.shipped import find_model, shipped_models
from tests.simsat.mjcf.edits import END, WORLD, at_end, behind, text

STONE = '<body><geom size="0.1"/></body>'
ROW = '<replicate count="{}" offset="0 0 1">{}</replicate>'


def written(folder: Path, xml: str, name: str = "craft.xml") -> Path:
    path = folder / name
    path.write_text(xml)
    return path


def asset(element: str) -> tuple[str, str]:
    return at_end(f"<asset>{element}</asset>")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (behind(WORLD, ROW.format(300_000, STONE)), r"300,0\d\d elements, 300,0\d\d of them <body"),
        (behind(WORLD, ROW.format(1000, ROW.format(1000, STONE))), r"1,000,0\d\d elements, "),
        (at_end('<size nkey="200000000"/>'), "<size nkey='200000000'> makes 200,000,000: at most"),
        (asset('<hfield name="h" nrow="9999" ncol="9999" size="1 1 1 1"/>'), "makes 99,980,001"),
        (
            asset('<texture name="t" builtin="flat" width="99999" height="99999"/>'),
            "width='99999' height='99999'> makes",
        ),
    ],
)
def test_what_would_keep_mujoco_busy_is_refused(
    tmp_path: Path, edit: tuple[str, str], message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        read_model(written(tmp_path, text(edit)))


def test_elements_are_counted_as_mujoco_makes_them(tmp_path: Path) -> None:
    """Repeated inside each other, included in a repetition, and attached from another file."""
    written(tmp_path, f"<mujocoinclude>{ROW.format(3, STONE)}</mujocoinclude>", "stones.xml")
    heap = (
        f"<mujoco><worldbody><body name='heap'>{ROW.format(5, STONE)}</body></worldbody></mujoco>"
    )
    written(tmp_path, heap, "heap.xml")
    path = written(
        tmp_path,
        "<mujoco><asset><model name='heap' file='heap.xml'/></asset><worldbody>"
        f"{ROW.format(7, STONE + ROW.format(2, STONE))}<include file='stones.xml'/>"
        "<body><attach model='heap' body='heap' prefix='a'/>"
        "<attach model='heap' body='heap' prefix='b'/></body></worldbody></mujoco>",
    )
    elements = Elements(tmp_path)
    elements.read(path, 1)
    m = mujoco.MjModel.from_xml_path(str(path))
    assert elements.counts["body"] == m.nbody - 1 == 21 + 3 + 1 + 2 * 6
    assert elements.counts["geom"] == m.ngeom


def test_a_file_that_includes_itself_ends(tmp_path: Path) -> None:
    path = written(tmp_path, "<mujoco><include file='craft.xml'/></mujoco>")
    assert list(too_large(path)) == []


def test_shipped_files_and_usual_pictures_are_far_from_too_large(tmp_path: Path) -> None:
    for name in shipped_models():
        path = find_model(name)
        elements = Elements(path.parent)
        elements.read(path, 1)
        assert 10 < elements.total < 200
    sky = '<texture type="skybox" builtin="gradient" width="512" height="3072"/>'
    assert read_model(written(tmp_path, text((END, f"<asset>{sky}</asset>{END}")))).wheels
