"""The flat of the home-care case, seen from above: the robot's base, gripper and battery, a person, and a dog.

- `flat`: where walls, furniture and goals are
- `house`: `House`, the world of a run
- `planar`: how the base moves and touches, by geometry; `engine`: the same in MuJoCo
- `laser`, `gripper`, `battery`: the parts of the robot
- `walkers`: the person and the dog; `routes`: the ways of both
- `picture`: the view from above, for films

It imports the robot's messages, and the runtime of the plugin.
"""
