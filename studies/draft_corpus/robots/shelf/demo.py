from shelf.picker import Fetch, Halt, Inputs, Picker, Put

picker, height = Picker(), 0.0
for tick in range(400):
    commands = {5: [Fetch("atlas", 2)], 200: [Put(1)], 210: [Halt("visitor")]}.get(tick, [])
    inputs = Inputs(commands, hand_seen=tick % 90 == 89, gripped=tick % 20 == 0, height_m=height)
    height += 0.1 * picker.update(inputs).lift_speed
