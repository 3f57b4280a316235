// Watches an arm move on two trajectories, and stops it with the emergency stop, or has its controller refuse.
@once  +!visit : one_run <- !look.
@watch +!look : watches <- wait.
@stop  +!look : stops   <- wait; emergency_stop; wait.
@off   +!look : is_off  <- refuse; wait.
