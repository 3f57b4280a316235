"""The closing loop: what is not covered yet drives what is run next.

observation        what one run yields: the points that it hits, and how near it came to others
targets            the points that are to be hit
way                the protocol of the ways to reach points: each proposes tests from what is known
archive            all runs, the best test of each point, what is still open
bandit             the choice among the ways, by what has paid off
loop               generations of proposals, run on any number of processes, merged in order
evidence           what all runs have shown of each point, and how much a further run would find
violations         kinds of violations: by part of a requirement, state of the code, and outcome of the interaction
open_points        points that no run hit: which came nearest, what it lacked, and how to declare it impossible
suite              the smallest part of the tests that covers as much as all
scripts            the model's scripts by the interactions that they plan
interactions       a script's interactions: what each plans, how it is disturbed, and what became of it
recipes            which disturbances of interactions lead to which bins, and how probably
experience         what all runs have taught about interactions
aiming             which script, and how to disturb it, so that probably many open bins are hit
nearness           which runs came near to an open point
cross_entropy      ranges of parameters, adapted to what came near
branching          tests with a common beginning as one tree: where they part, the process forks
tree_runner        trees on several processes, or each test from the start
decision_points    where a person could have done something else, and how worthwhile it is to come back there
continuations      what a person could have done
choice_statistics  what has come of the choices of people who decided during their runs
lived_run          a run in which the person decides what to do, and the test that it becomes
model_way, parameter_way, disturbance_way, branching_way, online_way      the ways

Independent of pytest: a run is a function that is handed in.
"""
