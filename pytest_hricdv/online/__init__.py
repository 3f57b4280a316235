"""Interactive agents: agents of people that live in the run and decide what the person does from what happens there.

- `declaration`: what a testbench declares: which agent, and what it perceives
- `role`: the declaration checked against the model, and prepared for all runs
- `decisions`: what there is to decide (beliefs, goals, one of several acts), and who decides it
- `online_agent`: the agent of one run: it perceives events, and gives one command after the other
- `online_people`, `enacted_lanes`: several such agents in one run, and what they did as lanes
"""
