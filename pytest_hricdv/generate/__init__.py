"""From belief subsets to tests: methods that generate abstract tests, and their concretization.

    beliefs, belief_sets            the space of beliefs, and a file of subsets of it
    model, model_runner             the BDI agents: their declaration, and running them with a subset
    exhaustive_exploration          all runs of a model
    qlearning, reward, learner      learning which beliefs cover many plans
    policy, saved_table             the subsets of the learned policy, a table in a file
    context                         what suites are generated from, and the protocol of methods
    rl, files, methods              the methods (rl with the greedy selection of tests), and all of them by name
    abstract, text_format, ids      abstract tests as data and as text, their ids and seeds
    sampler, concrete               declared ranges, and tests with parameters sampled from them
    suite                           the generated suite, and its diagnosis
    rng                             random streams, seeds and digests

Nothing is imported here, so that a process that only replays a suite loads no BDI engine.
"""
