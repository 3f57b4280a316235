"""The world's physics in PyBullet: the only modules that know of it.

- `client`: the library, without its banner
- `engine`: `BulletEngine`, the `sim.engine.Engine`
- `motors`: its drives
- `merging`: descriptions without fixed joints
- `seen`: shapes for pictures
"""
