"""The world's physics in MuJoCo: the only modules that know of it.

- `library`: the library, and robots that it loads
- `scene`: bodies in a model that is compiled anew when one is added or removed
- `engine`: `MujocoEngine`, the `sim.engine.Engine`
- `servos`: its drives
- `welds`: grips that give way
- `seen`: shapes for pictures
"""
