# Fig. 2: magnitude and phase of the rendered stiffness.
set terminal svg size 900,860 font "DejaVu Sans,14" enhanced background rgb "white"
set logscale x
set xrange [1:10000]
set lmargin 11
set rmargin 9
set multiplot

set tmargin at screen 0.915
set bmargin at screen 0.455
set label 1 heading at screen 0.5, 0.975 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.943 center noenhanced font ",12" textcolor rgb grey
set logscale y
set format y "10^{%L}"
set format x ""
set ylabel "|K_θ|  (N·m/rad)"
set arrow 1 from unmodified_corner_hz, graph 0 to unmodified_corner_hz, graph 1 nohead dashtype 2 linewidth 0.7 linecolor rgb grey
set arrow 2 from residual_corner_hz, graph 0 to residual_corner_hz, graph 1 nohead dashtype 2 linewidth 0.7 linecolor rgb grey
set arrow 3 from filter_corner_hz, graph 0 to filter_corner_hz, graph 1 nohead dashtype 2 linewidth 0.7 linecolor rgb grey
set arrow 4 from graph 0, first K_DC to graph 1, first K_DC nohead dashtype 2 linewidth 0.7 linecolor rgb grey
set arrow 5 from graph 0, first K_HF to graph 1, first K_HF nohead dashtype 2 linewidth 0.7 linecolor rgb grey
set label 3 "R/L" at unmodified_corner_hz, graph 0.03 rotate by 90 offset -0.7,0 textcolor rgb grey
set label 4 "dR/L" at residual_corner_hz, graph 0.03 rotate by 90 offset -0.7,0 textcolor rgb grey
set label 5 "λ" at filter_corner_hz, graph 0.03 offset -1.3,0 textcolor rgb grey
set label 6 "K_{DC}" at graph 1.01, first K_DC textcolor rgb grey
set label 7 "K_{HF}" at graph 1.01, first K_HF textcolor rgb grey
set key at graph 0.98, graph 0.30 right top opaque samplen 3
plot csv using 1:2 skip 1 with lines linewidth 3 dashtype 3 linecolor rgb grey title "unmodified motor", \
     csv using 1:3 skip 1 with lines linewidth 2 linecolor rgb blue title "analytic (12)", \
     csv using 1:4 skip 1 with lines linewidth 2 dashtype 4 linecolor rgb vermillion title "sampled", \
     csv using 1:5 skip 1 with points pointtype 6 pointsize 0.7 linewidth 1.5 linecolor rgb "black" title "measured"

set tmargin at screen 0.430
set bmargin at screen 0.085
unset label
unset arrow 4
unset arrow 5
unset key
unset logscale y
set yrange [-180:180]
set ytics 45
set format y "%g°"
set format x "%g"
set ylabel "phase (0°: spring, 90°: damper)"
set xlabel "frequency (Hz)"
plot csv using 1:6 skip 1 with lines linewidth 3 dashtype 3 linecolor rgb grey, \
     csv using 1:7 skip 1 with lines linewidth 2 linecolor rgb blue, \
     csv using 1:8 skip 1 with lines linewidth 2 dashtype 4 linecolor rgb vermillion, \
     csv using 1:9 skip 1 with points pointtype 6 pointsize 0.7 linewidth 1.5 linecolor rgb "black"
unset multiplot
