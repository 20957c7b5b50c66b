"""What breaks in flight, and when: wheels, instruments, the body's inertia.

`fault` says what there is and reads it from text; `damage` is its part in the plant, `senses` its
part in the instruments.
"""
