def test_race(hri_case):
    hri_case.check(hri_case.run())
