// Stands in front of a toy car that avoids obstacles, comes near, walks off; then nothing is in range of its sonar.
@once  +!visit : one_round  <- !round.
@twice +!visit : two_rounds <- !round; !round.
@near  +!round : comes_near <- stand(far); stand(near); stand(far).
@close +!round : is_close   <- stand(middle); stand(near).
@gone  +!round : walks_off  <- stand(far); stand(nowhere).
@fault +!round : cable_off  <- stand(far); stand(unplugged).
