def test_bench(hri_case):
    hri_case.check(hri_case.run())
