"""From what is measured to what is commanded: pure functions of numbers, and nothing else of ours.

It knows no engine, file, clock or global random state, and imports neither `simsat` nor `learning`.
Its name is `simsat.control`, wherever it is installed: plain `control` is python-control's.
"""

if __name__ == "control":
    raise ImportError(
        "this is simsat's folder 'control', whose name is 'simsat.control'; for python-control "
        "start Python outside the checkout of simsat"
    )
