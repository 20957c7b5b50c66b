"""A first flight: two wheels turn a spacecraft about the one axis that has none.

Prints:

    <two_wheel, nmpc-learned: 75 deg about (0.00, 0.00, 1.00): settled at 26 s, ...>
    peak wheel speed 2127 rpm, torque effort 2.36 Nms
    omega_x in rad/s, body axes, 801 samples: t_s, q_w, q_x, q_y, q_z, omega_x, ...
"""

import simsat

flight = simsat.fly(
    "two_wheel", controller="nmpc-learned", axis=(0, 0, 1), angle_deg=75, duration_s=40
)
print(flight)

figures, table = flight.metrics, flight.table
print(
    f"peak wheel speed {figures['peak_wheel_speed_rpm']:.0f} rpm, "
    f"torque effort {figures['torque_effort_Nms']:.2f} Nms"
)
about = table.schema.field("omega_x").metadata
print(
    f"omega_x in {about[b'unit'].decode()}, {about[b'frame'].decode()} axes, "
    f"{table.num_rows} samples: {', '.join(table.column_names[:6])}, ..."
)
flight.plot().savefig("first_flight.png", dpi=110)
flight.save("first_flight")
