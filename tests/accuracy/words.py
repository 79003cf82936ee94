"""What the page says around its tables."""

HEAD = """# Accuracy

Made by `make accuracy` from cases whose truth is known. Reference cases and real well are no part of this
repository: VSENSOR_REFERENCE_DATA and VSENSOR_FIELD_DATA name the folders where they lie. Other strings are
simulated here."""

EXACT = """
## Against exact truth

The cases were written by an independent program, a finely gridded solution of the wave equation, with
the noise of real channels: 80 N·m and 0.015 rad/s. Scored from 10 s on. *Share* is the rms error of bit
speed over the range of the true one; *within 2σ*, the share of errors within two stated standard
deviations, about 95% where a sensor is honest: those of ours hold noise, rock, and what is uncertain of
delay, impedance, inertia and wall friction by `[tuning]`. The load law starts from the true one and is
learned on.

Two yardsticks come first. *Surface speed* is what a driller sees today, taken for the bit's. *Two lumps* is
a Kalman filter for the string as two inertias and a spring, with the same configuration, wall friction
included, given the same samples: at the present, and as late as our confirmed answer. How fast the bit's
torque walks and how much noise stands for what lumps cannot do, it has to be told. *By likelihood* takes
what makes its innovations likeliest, as one does in the field; where the string swings, that filter takes
waves for rock. *By the truth* takes what gives the least error of bit speed in this very record, for each
row anew, out of {choices} choices: nobody can do so in the field, and it is about the most that such a
filter can reach."""

EXACT_ROWS = """
| answer | speed error, rpm | share | torque error, kN·m | torque bias, N·m \
| speed within 2σ | torque within 2σ |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |"""

LIMIT = """
### What nobody can know better

The rock is rough: its own torque is noise. No measured wave tells yet what it does between the confirmed
time and the time in question, and the channels' noise hides a part of what it has done. So there is a least
error, whatever the method. Here it is for *{case}*, on average over many such records, for one who knows
the string, the law and the rock's statistics exactly: the string by the matrices of its components at each
frequency (with the wall's viscous friction), the law by its slope at {rpm:.0f} rpm, the rock as noise of
{std:.0f} N·m with a correlation time of {time:g} s.

- *Confirmed*: a Wiener smoother that hears both noisy channels before and after the time in question.
- *Now* and *forecast*: waves without noise, so that all error is what the rock has done since. The first of
  each pair counts that from our confirmed time, {lag:.2f} s later than waves could tell it; the second from
  when they could.

| least error | speed, rpm | share | torque, kN·m |
| --- | ---: | ---: | ---: |"""

WELLS = """
## Other strings

Strings of every length and kind, simulated for 90 s each by `tests/leapfrog.py`: the wave equation stepped on
a fine grid of some thousand nodes, with proper sticking of the wall, a speed controller and rough rock. It
shares neither method nor code with the sensor, and is held against closed forms by tests of its own. What
the wells are made of, [tests/wells.py](../tests/wells.py), was put down once by a plain rule: drill pipe of
5 in above up to 150 m each of heavy-weight pipe and collars, a stiff controller that goes from 95 rpm to
143 rpm amid the record, rock that takes 6 kN·m to break loose and 3 kN·m while the bit turns, give or take
300 N·m. Unless a row says otherwise that is the well, 2500 m deep where no length is told, and none is left
out. Channels have the noise of the cases above, and the sensor is told the well as it is; the law, as it is
in the end. It is not told when the bit is off bottom, nor what is wrong with a reading.

Scored from 10 s on; columns as above, for each of the three answers. A bit that sticks has a wide range and
one that turns evenly a narrow one, of which the same error is a larger share.

| well | confirmed share | torque error, kN·m | speed within 2σ | torque within 2σ \
| now share | torque error, kN·m | speed within 2σ | torque within 2σ \
| forecast share | torque error, kN·m | speed within 2σ | torque within 2σ |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"""

DRAWN = """
### As wrong as it may be

No rig is told exactly. Each well again, {draws} times, with delay, impedance, inertia and wall friction wrong
all at once and by chance: normal, with the deviations that `[tuning]` states (1 %, 2 %, 5 %, 25 %), spread
evenly over what is likely. Errors are rms over the draws, shares within two deviations their mean. Here a
sensor is held to its word: it says what it may be wrong by, is told as wrongly, and about 95% should be
within.

| well | confirmed share | torque error, kN·m | speed within 2σ | torque within 2σ \
| now share | torque error, kN·m | speed within 2σ | torque within 2σ \
| forecast share | torque error, kN·m | speed within 2σ | torque within 2σ |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"""

WRONG = """
## With the configuration wrong

Each case again with a configuration that is wrong on purpose. *Wall* is that of pipe and collars, whose bore
has worn unknown to anyone; *all* is all but that. Friction is the borehole's, viscous and Coulomb; the load
law is the first guess, viscous, kinetic and static. Shares and torque errors are rms as above, each
scored from 10 s on, and in brackets from 40 s on, where a sensor that finds out has had its time (there a
share is of the range from 40 s on). *Two lumps* is the yardstick as late as our confirmed answer, wrong in
the same way, tuned by the truth as above. Surface speed cannot be configured wrongly.

The last four columns are what the sensor had corrected of itself by the end of the record, `[tuning]` as it
is by default: it begins after a minute. Right would be −1.5% of the delay for G −3 %, some −4% of the
impedance for a wall of +5 % (−3.7% of the pipe's, less of the collars'), −9.1% of the inertia for +10 %,
+43% of the friction for −30 %, and nothing where nothing is wrong. Delay and impedance stick-slip tells.
Inertia and friction it corrects only off bottom, and only where it is told so: on bottom, borehole and bit
take of the torque together, and nothing measured above parts them (but friction told so high that the bit
would drive its rock is taken back anywhere). So the last rows of each table begin with
*a tare*, as each connection gives it: for {tare:.0f} s the true string was turned off bottom by the simulated
rig, at {slow:.0f} and then at {turned:.0f} rpm, and the record goes on with what the wrongly configured
sensor had learned of it."""

WRONG_ROWS = """
| what is wrong | two lumps share | confirmed share | confirmed torque, kN·m | now share | forecast share \
| confirmed speed within 2σ | confirmed torque within 2σ | now speed within 2σ | forecast speed within 2σ \
| delay corrected | impedance corrected | inertia corrected | friction corrected |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"""

SCRATCH = """
## With the law learned from scratch

The load law starts at a guess that knows nothing of the rock: 1 kN·m, whatever the speed. Scored from 30 s
on; in brackets, what comes out when it starts from the true one.

| case | answer | share | torque error, kN·m | torque bias, N·m | speed within 2σ | torque within 2σ |
| --- | --- | ---: | ---: | ---: | ---: | ---: |"""

STICKS = """
## Sticks foretold

Each stick is announced once, and each announcement held against what is confirmed in the end: a bit that
rests for 0.1 s, within 0.3 s of the time foretold. The first ones of a record come before the load law is
known. The reference cases, and {seconds:.0f} s of the simulated rig of
[config/drilling.toml](../config/drilling.toml) in stick-slip, with drill pipe of any length above 350 m of
heavy-weight pipe and collars. The warning is until the stick came, which may be a little later than foretold.

| case | seen ahead, s | came as announced | came unannounced | announced in vain | warning, mean, s \
| share of what is seen |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |"""

LAG = """
## What the lag buys

For `[estimator] lag` later samples correct an answer before it is confirmed. The longer it is, the less noise
and rock leave of error, and the later the answer comes; beyond some tenths of a second little is left to
gain, until the wave has run the string once more. For
[config/drilling.toml](../config/drilling.toml):"""

FIELD = """
## Against a real well

Well B of Aarsnes and Shor (2018), 1733 m, rotation started off bottom after a connection: least and
greatest bit speed of each half second from a downhole sensor. Configuration:
[config/well-b.toml](../config/well-b.toml), plain steel, nothing fitted but the wall friction, which is the
surface torque of steady rotation.

The record's two clocks do not agree: not in their zero, which the comparison finds (within half a second,
by the least error), nor in their rate. String and bit swing as one, yet the period of stick-slip is
{above:.3f} s in the surface torque and {below:.3f} s in the bit's speed: a least-squares fit of three
harmonics to each from 16 s on, in which no model has a part. So the downhole clock, or the axis that it was
read from, runs {slow:.2%} slow: one moment comes to stand a third of a second apart over the record. Errors
are told twice, by that clock as it stands and *by one clock*, set right by the ratio of the two periods.

The bit's true torque is zero, so the mean torque, from 20 s on, is all
error. A *tare* takes off what the wall friction is wrong by: the mean confirmed torque of the record's first
third ({third:.0f} s), while the bit is confirmed to turn faster than {turning:.0f} rpm. What is left is the
mean over the other two thirds. Where the sensor is told that the bit is off bottom, it takes
a tare of its own, where the string turns steadily, and corrects the wall friction by what the last column
says. Here the bit swings all along, and it takes none.

| told | answer | midpoint error, rpm | correlation | the same by one clock, rpm | correlation \
| mean torque from 20 s, kN·m | mean of the last two thirds, kN·m | the same after the tare, kN·m \
| friction corrected |
| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"""
