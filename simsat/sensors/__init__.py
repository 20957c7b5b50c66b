"""What the instruments make of the truth: star tracker, gyro, tachometers, Sun sensor.

An instrument is a function of the plant's log whose errors are drawn beforehand, one row per sample
of the flight: asked twice it answers the same. `suite` puts them together into what the loop senses
with. Metrics always judge the truth.
"""
