"""What a file may not say: each refusal in one sentence with its remedy, all collected by `reader`.

Measured reasons: 33 deg of attitude error in 100 s under Euler or implicitfast with wheel bias,
2e-8 deg under RK4; an armature cuts a wheel's reaction on the bus by J/(J + armature) while the
momentum sensor looks fine; friction at the default solver tolerance leaks 2.5e-7 Nm, the size of
drag.
"""
