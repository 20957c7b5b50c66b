"""The instruments that settings ask for."""

from dataclasses import dataclass

import numpy as np

from simsat.environment.orbit import Orbit
from simsat.flight.loop import Sense, sense_truth
from simsat.sensors.gyro import build_gyro
from simsat.sensors.settings import SensorSettings
from simsat.sensors.sheets import DataSheet
from simsat.sensors.sky import Sky
from simsat.sensors.star_tracker import build_star_tracker
from simsat.sensors.suite import Suite
from simsat.sensors.sun_sensor import build_sun_sensor
from simsat.sensors.tachometers import build_tachometers
from simsat.sensors.truth import TRUTH
from simsat.sensors.white import build_white_noise


@dataclass(frozen=True)
class Span:
    """What instruments need to know of a flight to draw their errors."""

    rows: int
    """Samples, the start included."""
    tick: float
    """s between samples."""
    wheels: int
    orbit: Orbit


def build_sense(settings: SensorSettings, span: Span) -> Sense:
    """What the loop senses with. Raises `SettingsError` on figures that don't fit the flight."""
    suite = build_suite(settings, span)
    return sense_truth if suite is TRUTH else suite


def build_suite(settings: SensorSettings, span: Span) -> Suite:
    """The same as instruments one by one."""
    sheet = settings.sheet
    if sheet is not None:
        return build_instruments(sheet, settings.seed, span)
    if settings.enabled:
        return build_white_noise(settings, span.rows, span.tick, span.wheels).suite
    return TRUTH


def build_instruments(sheet: DataSheet, seed: int, span: Span) -> Suite:
    """Instruments of a data sheet, each with a stream of noise of its own: one more changes none of
    the others."""
    streams = np.random.SeedSequence(seed).spawn(4)
    tracker, gyro, tachometers, sun = map(np.random.default_rng, streams)
    rows, tick, sky = span.rows, span.tick, Sky(span.orbit)
    return Suite(
        build_gyro(sheet.gyro, rows, tick, gyro),
        build_tachometers(sheet.tachometer, rows, span.wheels, tachometers),
        build_star_tracker(sheet.tracker, sky, rows, tick, tracker),
        () if sheet.sun is None else (build_sun_sensor(sheet.sun, sky, rows, tick, sun),),
    )
