"""The world's physics in MuJoCo: the only modules that know of it.

- `library`: the library, and robots that it loads
- `body`: bodies, and where they are in the compiled model
- `scene`: model and state; compiled anew when a body is added or removed
- `engine`: `MujocoEngine`, the `sim.engine.Engine`
- `servos`: its drives
- `welds`: grips that give way
- `seen`: shapes for pictures
"""
