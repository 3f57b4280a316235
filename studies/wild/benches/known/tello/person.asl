// Flies a small drone with a program: starts or throws it, looks at its battery, stops its motors, or sees it crash; then ends.
@go     +!visit : starts     <- !look; takeoff; stay; !stop; !fall; end.
@throw  +!visit : is_thrown  <- !look; throw; stay; !stop; !fall; end.
@down   +!visit : stays_down <- !look; stay; !stop; !fall; end.
@looks  +!look : looks        <- state.
@blind  +!look.
@press  +!stop : presses_stop <- emergency; stay.
@calm   +!stop.
@crash  +!fall : crashes      <- crash; stay.
@safe   +!fall.
