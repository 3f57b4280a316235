"""The model as an oracle: one of its agents follows each run, and the code under test has to act as it does.

- `execution`: its part in the execution of tests
- `oracle`: the declaration of a testbench, checked against model and vocabulary, and prepared for all runs
- `product`: agent and observed events step by step: what is expected, and what deviates
- `conformance_monitor`: follows one run, and gives the verdict
"""
