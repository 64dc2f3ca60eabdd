# Figure 7: direction error of the transpose map over frequency.
set terminal svg size 900,600 font "DejaVu Sans,14" enhanced background rgb "white"
set label 1 heading at screen 0.5, 0.965 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.925 center noenhanced font ",12" textcolor rgb grey
set tmargin at screen 0.89
set bmargin at screen 0.13
set rmargin 5
set logscale x
set xrange [1:1000]
set yrange [0:*<90]
set offsets 0, 0, 6, 0
set format y "%g°"
set xlabel "frequency at which the tip vibrates (Hz)"
set ylabel "largest angle from the normal to the force"
set key top left reverse Left samplen 3 spacing 1.2 opaque
set object 1 rectangle from 20, graph 0 to 30, graph 1 fillcolor rgb "#EEE6C8" fillstyle solid noborder behind
set label 3 "kinesthetic limit" at 24.5, graph 0.97 rotate by 90 right textcolor rgb grey font ",11"
set arrow 1 from 1, first 25 to 1000, first 25 nohead dashtype 2 linewidth 1.5 linecolor rgb "black"
set label 4 "limit of direction perception: 25°" at 1.1, first 25 offset 0,-0.7 textcolor rgb "black" font ",11"
set arrow 2 from half_servo_hz, graph 0 to half_servo_hz, graph 1 nohead dashtype 3 linecolor rgb grey
set label 5 "half the servo rate" at half_servo_hz, graph 0.03 rotate by 90 offset -0.7,0 textcolor rgb grey font ",11"

plot csv using 1:2 skip 1 with lines linewidth 2.5 linecolor rgb vermillion title "J^{-1}", \
     csv using 1:3 skip 1 with lines linewidth 2.5 dashtype 2 linecolor rgb blue title "J^{T}, λ 300 rad/s", \
     csv using 1:4 skip 1 with lines linewidth 2.5 linecolor rgb blue title "J^{T}, λ 1000 rad/s", \
     csv using 1:5 skip 1 with lines linewidth 2.5 dashtype 4 linecolor rgb blue title "J^{T}, λ 3000 rad/s"
