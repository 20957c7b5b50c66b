"""Studies: every combination of the values, each read as the command line would read it."""

from pathlib import Path

import pytest

from simsat.campaign.study import Variation, at_point, grid, label, parse_variation, read_study
from simsat.comparison.statistics import METRICS, Aggregate, Summary
from simsat.comparison.study_picture import abscissa, curves
from simsat.comparison.study_rows import StudyRow, study_rows
from simsat.comparison.study_table import study_table, write_study
from simsat.control.ground.errors import SettingsError
from simsat.settings import FlightSettings


def test_vary_is_read_with_either_dash() -> None:
    assert parse_variation("nominal.mismatch=0,1, 2") == Variation(
        "nominal.mismatch", ("0", "1", "2")
    )
    assert parse_variation("orbit.altitude-km=400") == parse_variation("orbit.altitude_km = 400")
    assert parse_variation("--orbit.altitude-km=400").name == "orbit.altitude_km"


def test_grid_is_every_combination_the_last_fastest() -> None:
    points = grid((Variation("a", ("1", "2")), Variation("b", ("x", "y"))))
    assert [label(p) for p in points] == ["a=1, b=x", "a=1, b=y", "a=2, b=x", "a=2, b=y"]
    assert grid(()) == ({},)


def test_values_take_the_type_of_their_setting() -> None:
    point = {
        "nominal.mismatch": "2",
        "nmpc.horizon": "20",
        "environment.drag": "false",
        "environment.density_model": "nrlmsis",
        "nominal.inertia_factors": "1 1.1 0.9",
        "start.wheel_speed_rpm": "100 -100",
        "model": "two wheel/folder.xml",
        "nmpc.keep_rate_below_deg_s": "none",
    }
    settings = at_point(FlightSettings(), point)
    assert settings.nominal.mismatch == 2.0
    assert isinstance(settings.nominal.mismatch, float)
    assert settings.nmpc.horizon == 20
    assert settings.environment.drag is False
    assert settings.environment.density_model == "nrlmsis"
    assert settings.nominal.inertia_factors == (1.0, 1.1, 0.9)
    assert settings.start.wheel_speed_rpm == (100.0, -100.0)
    assert settings.model == Path("two wheel/folder.xml")
    assert settings.nmpc.keep_rate_below_deg_s is None
    assert settings.orbit == FlightSettings().orbit  # the rest is untouched


def test_study_file_lists_settings_dotted_or_in_tables(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(
        'model = ["two_wheel", "pyramid"]\n'
        "nominal.mismatch = [0, 1.5]\n"
        "nominal.inertia-factors = [[1, 1, 1], [0.9, 1.1, 1]]\n"
        "[environment]\n"
        "drag = [true, false]\n"
    )
    assert read_study(path) == (
        Variation("model", ("two_wheel", "pyramid")),
        Variation("nominal.mismatch", ("0", "1.5")),
        Variation("nominal.inertia_factors", ("1 1 1", "0.9 1.1 1")),
        Variation("environment.drag", ("True", "False")),
    )


@pytest.mark.parametrize("text", ["nominal.mismatch", "=1", "nominal.mismatch=", "a=1,,2"])
def test_vary_without_name_or_values_is_refused(text: str) -> None:
    with pytest.raises(SettingsError, match=f"takes NAME=VALUE,VALUE,..., got '{text}'"):
        parse_variation(text)


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ({"nominal.mismach": "1"}, "no setting 'nominal.mismach'.*did you mean mismatch?"),
        ({"weights.attitude": "1"}, "no setting 'weights.attitude': no 'weights'; there are: mode"),
        ({"nominal": "1"}, "'nominal' is a group; vary one of inertia_factors, mismatch in it"),
        ({"duration_s.x": "1"}, "nothing is inside 'duration_s'"),
        ({"nominal.mismatch": "much"}, "'much' does not fit the setting 'nominal.mismatch'"),
        (
            {"nmpc.horizon": "2.5"},
            r"'2.5' does not fit the .* 'nmpc.horizon': give a whole number",
        ),
        ({"nominal.inertia_factors": "1 2"}, "'1 2' does not fit"),
        ({"duration_s": "-1"}, "--duration-s is -1: give a finite number above 0"),
    ],
)
def test_points_that_fit_no_setting_are_refused(point: dict[str, str], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        at_point(FlightSettings(), point)


def test_settings_chosen_by_other_means_are_not_varied() -> None:
    with pytest.raises(SettingsError, match="'controller' is chosen by --controllers, not varied"):
        grid((parse_variation("controller=nmpc,nmpc-pinn"),))
    with pytest.raises(SettingsError, match="'angle_deg' is chosen by --attitudes"):
        grid((parse_variation("angle-deg=1,2"),))
    with pytest.raises(SettingsError, match="'a' is varied twice"):
        grid((Variation("a", ("1",)), Variation("a", ("2",))))
    with pytest.raises(SettingsError, match=r"'nominal.mismatch' lists 1 more than once"):
        parse_variation("nominal.mismatch=1,2,1")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "varies nothing; write lines like nominal.mismatch"),
        ("nominal.mismatch = 1", "nominal.mismatch must be a list of values, got 1"),
        ("nominal.mismatch = []", "nominal.mismatch must be a list of values"),
        ("nominal.mismatch: [1]", "is no TOML"),
    ],
)
def test_bad_study_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=message):
        read_study(path)
    with pytest.raises(SettingsError, match=r"no study at '.*absent.toml': give a file"):
        read_study(tmp_path / "absent.toml")


def row(study: str, controller: str, error: float | None) -> dict[str, object]:
    return {
        "study": study,
        "controller": controller,
        "converged": error is not None,
        "final_error_deg": error,
        "steady_state_rmse_deg": error,
        "settling_time_s": None if error is None else 30.0,
    }


def test_study_rows_are_aggregated_point_by_point() -> None:
    rows = [row("a=1", "nmpc", 1.0), row("a=1", "nmpc", 3.0), row("a=2", "nmpc", None)]
    records = [{"point": {"a": "1"}}, {"point": {"a": "1"}}, {"point": {"a": "2"}}]
    table = study_rows(records, rows)
    assert [(r.point, r.result.runs, r.result.converged) for r in table] == [
        ({"a": "1"}, 2, 2),
        ({"a": "2"}, 1, 0),
    ]
    head, body = study_table(table)
    assert head[:4] == ["a", "controller", "runs", "converged"]
    first = dict(zip(head, body[0], strict=True))
    assert (first["Final error mean, deg"], first["Final error max, deg"]) == ("2", "3")
    assert body[1] == ["2", "nmpc", "1", "0", *[""] * 6]  # figures that don't exist stay empty


def test_a_setting_that_stays_the_same_is_no_abscissa() -> None:
    summaries = {metric.name: Summary(3, 0.2, 0.1, 0.5) for metric in METRICS}
    table = [
        StudyRow({"sensors.enabled": "True", "noise": n}, Aggregate("nmpc", 3, 3, summaries))
        for n in ("0", "10")
    ]
    assert abscissa(table) == "noise"
    assert list(curves(table)) == [("nmpc", "sensors.enabled=True")]


@pytest.mark.parametrize("values", [("0", "1", "2"), ("two_wheel", "pyramid")])
def test_study_is_written_as_table_and_picture(tmp_path: Path, values: tuple[str, ...]) -> None:
    summaries = {metric.name: Summary(3, 0.2, 0.1, 0.5) for metric in METRICS}
    table = [
        StudyRow({"model": value, "nmpc.horizon": h}, Aggregate(controller, 3, 3, summaries))
        for value in values
        for h in ("20", "24")
        for controller in ("nmpc", "nmpc-pinn")
    ]
    text = write_study(tmp_path, table)
    assert text == (tmp_path / "study.md").read_text()
    assert text.count("\n") == 2 + len(table)
    assert (tmp_path / "study.csv").read_text().count("\n") == 1 + len(table)
    assert (tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")
