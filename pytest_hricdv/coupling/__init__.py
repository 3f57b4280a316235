"""Agents of the model coupled to a simulated run: they live in its time and perceive its events.

- `percept_mapping`: what a testbench declares: which events the agent perceives, and as what
- `agent_names`: the agents of a model, and what each can perceive and do
- `events`: which declared events happen in the run, and the literal that each stands for
- `coupled_agent`: agents that pause before their acts, and whose clock is set from outside
"""
