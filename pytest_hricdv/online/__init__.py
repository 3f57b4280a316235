"""Interactive agents: agents of people that live in the run and decide what the person does from what happens there.

- `declaration` (what a testbench declares: which agent, and what it hears)
- `role` (the declaration checked against the model, and made ready for all runs)
- `chooser` (what there is to decide, and who decides it: which beliefs, which goals, which of several acts)
- `late_beliefs` (groups of beliefs that are decided when the agent looks one of them up)
- `online_agent` (the agent of one run: it hears, and gives one command after the other)
- `online_actions` (the actions of a run, produced when the person asks for them)
"""
