# A device's rendered stiffness by sine sweep: magnitude, phase, and by how much they differ from the
# sampled form.
set terminal svg size 900,1000 font "DejaVu Sans,14" enhanced background rgb "white"
set logscale x
set lmargin 11
set rmargin 4
of_motor(m, column) = $1 == m ? column : NaN
point_of(m) = m == 1 ? 4 : m == 2 ? 6 : 8
color_of(m) = m == 1 ? "black" : m == 2 ? green : vermillion
stats csv using 1 skip 1 nooutput name "motors"
first_motor = int(motors_min)
last_motor = int(motors_max)
stats csv using 2 skip 1 nooutput name "freq"
set xrange [freq_min / 1.15:freq_max * 1.15]
lowest = 1e99
highest = 0
do for [c in "3 6 8"] {
    stats csv using int(c) skip 1 nooutput name "K"
    lowest = K_min < lowest ? K_min : lowest
    highest = K_max > highest ? K_max : highest
}
set multiplot

set tmargin at screen 0.92
set bmargin at screen 0.57
set label 1 heading at screen 0.5, 0.978 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.948 center noenhanced font ",12" textcolor rgb grey
set logscale y
set format x ""
eval log_tics("y", lowest, highest, 14)
set ylabel "|K_θ|  (N·m/rad)"
set key top left opaque samplen 3
plot for [m=first_motor:last_motor] csv using (of_motor(m, $2)):8 skip 1 with lines linewidth 2 linecolor rgb grey title (m == first_motor ? "analytic (12)" : ""), \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):6 skip 1 with lines linewidth 2 linecolor rgb blue title (m == first_motor ? "sampled, with the measured d" : ""), \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):3 skip 1 with points pointtype point_of(m) pointsize 0.8 linewidth 1.5 linecolor rgb color_of(m) title sprintf("motor %d, measured", m)

set tmargin at screen 0.55
set bmargin at screen 0.32
unset label
unset key
unset logscale y
set ytics autofreq
set format y "%g°"
set ylabel "phase (0°: spring, 90°: damper)"
plot for [m=first_motor:last_motor] csv using (of_motor(m, $2)):9 skip 1 with lines linewidth 2 linecolor rgb grey, \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):7 skip 1 with lines linewidth 2 linecolor rgb blue, \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):4 skip 1 with points pointtype point_of(m) pointsize 0.8 linewidth 1.5 linecolor rgb color_of(m)

set tmargin at screen 0.30
set bmargin at screen 0.07
set format y "%g"
set format x "%g"
set ylabel "measured to sampled"
set xlabel "frequency (Hz)"
set key top left samplen 3
# Room for the legend above all points.
stats csv using (abs($10) + $5) skip 1 nooutput name "percent"
stats csv using (abs($11)) skip 1 nooutput name "degrees"
reach = percent_max > degrees_max ? percent_max : degrees_max
set yrange [-1.1 * reach:1.9 * reach]
plot 0 with lines linewidth 1 linecolor rgb grey notitle, \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):10:5 skip 1 with yerrorlines pointtype point_of(m) pointsize 0.8 linewidth 1.5 linecolor rgb color_of(m) title (m == first_motor ? "magnitude (%), with its deviation" : ""), \
     for [m=first_motor:last_motor] csv using (of_motor(m, $2)):11 skip 1 with linespoints dashtype 3 pointtype point_of(m) pointsize 0.5 linewidth 1.5 linecolor rgb color_of(m) title (m == first_motor ? "phase (°)" : "")
unset multiplot
