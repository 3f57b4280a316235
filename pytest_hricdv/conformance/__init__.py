"""The model as an oracle: one of its agents follows each run, and the code under test has to do what the agent does.

- `declaration` (what a testbench declares: what corresponds to what)
- `terms` (values of a run as terms of AgentSpeak), `agent_names` (what the agent can hear and do)
- `oracle` (the declaration checked against model and vocabulary, and made ready)
- `follower` (the agent, which goes on only when what it does has been observed)
- `events` (which declared events happen in the run)
- `product` (agent and observed events step by step: what is expected, and what deviates)
- `conformance_monitor` (follows one run, and gives the verdict)
"""
