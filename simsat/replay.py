"""Play a torque profile open loop on a spacecraft, with the same outputs as a closed-loop run."""

from simsat.errors import DivergedError
from simsat.loop import Ending, Flight, Watch
from simsat.plant import Plant, whole_steps
from simsat.profile import Profile


def play(plant: Plant, profile: Profile, watch: Watch = lambda flight: None) -> Flight:
    """Fly a profile from its own start; a flight that diverges ends early and says why."""
    ticks = whole_steps(profile.row_s, plant.tick, "profile row dt_u")
    flight = Flight(plant, ticks)
    plant.reset(profile.q, profile.omega, profile.wheel_speed)
    try:
        for torque in profile.torque:
            flight.commands.append(torque)
            plant.advance(torque, ticks)
            watch(flight)
    except DivergedError as error:
        flight.ending, flight.reason = Ending.DIVERGED, str(error)
    except KeyboardInterrupt:
        flight.ending = Ending.INTERRUPTED
        flight.reason = f"interrupted at t = {plant.state().t:.2f} s"
    return flight
