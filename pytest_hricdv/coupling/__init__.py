"""Agents of the model coupled to a simulated run: they live in its time and perceive its events.

- `hears` (what a testbench declares: what the agent hears when something happens)
- `terms` (values of a run as terms of AgentSpeak), `agent_names` (what an agent can hear and do), `agents` (reads them)
- `events` (which declared events happen in the run), `event_pattern` (an event, and the literal that it stands for)
- `coupled_run` (agents with a clock that is set from outside), `coupled_agent` (an agent that stops before its acts)
"""
