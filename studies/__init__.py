"""Studies behind the figures in docs/: the paper's experiment repeated, and what the chosen settings change.

experiment   the four methods beside the paper's figures        docs/studies/experiment.md
agreement    the original's own tests, run here                 docs/studies/agreement.md
convergence  what the step size of physics changes              docs/studies/convergence.md
rewards      which reward learns the better suite               docs/studies/rewards.md
adequacy     the seeded faults that each suite notices          docs/studies/adequacy.md
closure      how fast points are reached, and by which way     docs/studies/closure.md
false_alarms what fails on the unchanged controller             docs/studies/false-alarms.md
screenshots  the README's pictures, one of which moves (moving_picture)
freshness    which of them are older than what they show
"""
