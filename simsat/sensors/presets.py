"""Three sets of instruments, each of its class. A figure with a number is from that source; one
without is a guess of ours, of the order such instruments have.

 1. NASA Ames, Small Spacecraft Technology State of the Art, chapter 5, table 5-1
    (sst-soa.arc.nasa.gov/05-guidance-navigation-and-control): star trackers 25 arcsec, Sun sensors
    0.1 deg, gyros 1 deg/h and 0.1 deg/sqrt(h) are the state of the art of small spacecraft.
 2. University of Toronto Aerospace Team, Star Tracker Selection (utat-ss.notion.site): refresh
    rates of CubeSpace CubeStar 1 Hz, Hyperion ST200 5 Hz, arcsec Sagitta 10 Hz; noise about the
    boresight three times that across it for the CubeStar.
 3. Erlank, Development of CubeStar, Stellenbosch University, section 6.3: one match takes 1000 ms,
    of which the image is worked on for 0.8 s.
 4. Movella, MTi-300 data sheet, May 2023: 450 deg/s, 10 deg/h in run, 0.01 deg/s/sqrt(Hz), which is
    0.6 deg/sqrt(h).
 5. Blue Canyon Technologies, NST: 6 arcsec across the boresight, 40 about it.
 6. Sensonor, STIM210: 0.15 deg/sqrt(h), 0.3 deg/h as the lowest point of the Allan curve, scale
    factor +-500 ppm (sensonor.com, FAQ), 400 deg/s.
 7. Percival and others, ST5000 star tracker (University of Wisconsin, flight of August 2007):
    10 Hz, 0.54 arcsec across the boresight, 17 about it.
 8. Airbus Defence and Space, Astrix 120: 0.002 deg/sqrt(h), 0.01 deg/h, scale factor 100 ppm.
 9. Muruganandan and others, Arcsecond Pico Star Tracker, Trans. JSASS 60(6), 2017: baffle with an
    exclusion angle of 27 deg.
10. Dzamba, Enright and others, SSC12-X-7: 1 deg/s is a goal for small trackers at arcseconds.
"""

from simsat.sensors.sheets import (
    DataSheet,
    GyroSheet,
    StarTrackerSheet,
    SunSensorSheet,
    TachometerSheet,
)

CUBESAT = DataSheet(
    tracker=StarTrackerSheet(
        rate_hz=1.0,  # [2]
        latency_s=0.8,  # [3]
        across_arcsec=25.0,  # [1]
        about_arcsec=75.0,  # [2], the ratio
        rate_limit_deg_s=1.0,  # [10]
        sun_exclusion_deg=45.0,
        earth_exclusion_deg=27.0,  # [9]
        outlier_share=0.01,
    ),
    gyro=GyroSheet(
        angle_random_walk_deg_sqrt_h=0.6,  # [4]
        bias_instability_deg_h=10.0,  # [4]
        rate_random_walk_deg_h_sqrt_h=30.0,
        bias_deg_h=20.0,
        scale_factor_ppm=1000.0,
        misalignment_mrad=1.0,
        range_deg_s=450.0,  # [4]
    ),
    tachometer=TachometerSheet(resolution_rpm=2.0, noise_rpm=2.0),
    sun=SunSensorSheet(rate_hz=2.0, noise_deg=0.5),
)
"""MEMS gyro and a tracker of a few hundred grams."""

SMALLSAT = DataSheet(
    tracker=StarTrackerSheet(
        rate_hz=5.0,
        latency_s=0.2,
        across_arcsec=6.0,  # [5]
        about_arcsec=40.0,  # [5]
        rate_limit_deg_s=2.0,
        sun_exclusion_deg=40.0,
        earth_exclusion_deg=25.0,
        outlier_share=0.002,
    ),
    gyro=GyroSheet(
        angle_random_walk_deg_sqrt_h=0.15,  # [6]
        bias_instability_deg_h=0.3,  # [6]
        rate_random_walk_deg_h_sqrt_h=1.0,
        bias_deg_h=2.0,
        scale_factor_ppm=500.0,  # [6]
        misalignment_mrad=0.5,
        range_deg_s=400.0,  # [6]
    ),
    tachometer=TachometerSheet(resolution_rpm=0.5, noise_rpm=1.0),
    sun=SunSensorSheet(rate_hz=5.0, noise_deg=0.1),  # [1]
)
"""What today's white-noise settings stand for: a tactical MEMS gyro and a nano star tracker."""

HIGHEND = DataSheet(
    tracker=StarTrackerSheet(
        rate_hz=10.0,  # [7]
        latency_s=0.1,
        across_arcsec=0.6,  # [7]
        about_arcsec=17.0,  # [7]
        rate_limit_deg_s=3.0,
        sun_exclusion_deg=30.0,
        earth_exclusion_deg=20.0,
        outlier_share=0.0005,
    ),
    gyro=GyroSheet(
        angle_random_walk_deg_sqrt_h=0.002,  # [8]
        bias_instability_deg_h=0.01,  # [8]
        rate_random_walk_deg_h_sqrt_h=0.01,
        bias_deg_h=0.05,
        scale_factor_ppm=100.0,  # [8]
        misalignment_mrad=0.05,
        range_deg_s=60.0,
    ),
    tachometer=TachometerSheet(resolution_rpm=0.1, noise_rpm=0.1),
    sun=SunSensorSheet(rate_hz=10.0, noise_deg=0.02),
)
"""Fibre-optic gyro and a full-size tracker."""

PRESETS = {"cubesat": CUBESAT, "smallsat": SMALLSAT, "highend": HIGHEND}
