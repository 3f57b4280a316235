"""From beliefs to tests: the ways to generate abstract tests, and their concretization.

    beliefs        the space of beliefs that subsets are chosen from
    model, explorer, exploration   the BDI agents, running them with a subset, what a run shows
    qlearning, policy              learning which beliefs cover much, and the subsets that follow
    rl, by_hand, bdi_random, pseudorandom, files   the methods; `method` is their protocol, `registry` their names
    abstract, text, identity       tests as data, as text, and their ids and seeds
    sampler, concrete              declared ranges, and tests with their parameters sampled from them
    suite                          what a method generates, and the key it is cached under

Nothing is imported here, so that a process that only replays a suite loads no BDI engine.
"""
