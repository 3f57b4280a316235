"""Who is in the flat with the robot, and what they do there.

- `beliefs`: the models, and what they are steered by
- `coupling`: which events of a run the agents of the models hear and do
- `ranges`: the commands of a test, and from what their parameters are drawn
- `person`: the node of the person, who enacts a test
- `dog`: the bystander, and its node

It imports the robot's messages, the world, and the plugin's testbench.
"""
