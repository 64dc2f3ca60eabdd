# Settings of all charts; app/figures/figure.h documents where csv, svg and the marks come from.
# Colour-blind safe colours (Okabe and Ito), on white, for print.
set encoding utf8
set minussign
set datafile separator ","
set output svg
blue = "#0072B2"
vermillion = "#D55E00"
green = "#009E73"
grey = "#777777"
pale = "#DDDDDD"
set border linewidth 1
set tics nomirror out
set grid linecolor rgb pale linewidth 0.5

# eval log_tics("y", low, high, room): numbers on a logarithmic axis of any spread that has room for so
# many of them. Less than half a decade has equal steps; more has digits of each decade, powers of ten,
# or each second, third, ... of these.
round_up(v) = round_up_in(v, 10.0**floor(log10(v)))
round_up_in(v, decade) = decade*(v <= decade ? 1 : v <= 2*decade ? 2 : v <= 5*decade ? 5 : 10)
log_number(digit, e) = e > -4 && e < 5 ? gprintf("%g", digit*10.0**e) : digit eq "1" ? sprintf("10^{%d}", e) : sprintf("%s·10^{%d}", digit, e)
linear_tics(axis, low, high, step) = sprintf("set %stics (); set for [k=%d:%d] %stics add (gprintf('%%.9g', k*%.17g) k*%.17g)", axis, ceil(low/step), floor(high/step), axis, step, step)
digit_tics(axis, low, high, digits, each) = sprintf("set %stics (); set for [e=%d:%d:%d] for [m in '%s'] %stics add (log_number(m, e) m*10.0**e)", axis, each*floor(log10(low)/each), ceil(log10(high)), each, digits, axis)
log_tics_over(axis, low, high, decades, room) = decades < 0.5 ? linear_tics(axis, low, high, round_up((high - low)/5)) : digit_tics(axis, low, high, decades < 0.045*room ? "1 2 3 4 5 6 7 8 9" : decades < 0.14*room ? "1 2 3 5 7" : decades < 0.3*room ? "1 2 5" : "1", ceil(decades/room))
log_tics(axis, low, high, room) = high > 1.00001*low ? log_tics_over(axis, low, high, log10(high/low), room) : sprintf("set %stics autofreq", axis)
