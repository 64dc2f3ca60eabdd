# Fig. 6: how far the force points away from each surface's normal.
set terminal svg size 900,640 font "DejaVu Sans,14" enhanced background rgb "white"
set label 1 heading at screen 0.5, 0.968 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.930 center noenhanced font ",12" textcolor rgb grey
set label 3 conditions at screen 0.5, 0.898 center noenhanced font ",12" textcolor rgb grey
set tmargin at screen 0.87
set bmargin at screen 0.28
set xrange [-5:360]
set xtics 45
set mxtics 3
set format x "%g°"
set format y "%g°"
set xlabel "angle of the surface's normal, from outward to up"
set ylabel "angle from the normal to the force"
set offsets 0, 0, 3, 3
set key at screen 0.5, 0.155 center top maxrows 4 samplen 2.5 enhanced

# The angle between n and K n.
set samples 721
x_of(a) = K_xx*cos(a) + K_xy*sin(a)
y_of(a) = K_xy*cos(a) + K_yy*sin(a)
error(a) = atan2(cos(a)*y_of(a) - sin(a)*x_of(a), cos(a)*x_of(a) + sin(a)*y_of(a)) * 180/pi

plot error(x*pi/180) with lines linewidth 2 linecolor rgb vermillion title "J^{-1}, predicted", \
     csv using 1:2 skip 1 with points pointtype 5 pointsize 0.8 linecolor rgb vermillion title "J^{-1}, observed, ".inverse_penetration." inside", \
     csv using 1:7 skip 1 with points pointtype 4 pointsize 1.1 linewidth 1.5 linecolor rgb vermillion title "J^{-1}, not observed", \
     0 with lines linewidth 2 linecolor rgb blue title "J^{T}, predicted", \
     csv using 1:3 skip 1 with points pointtype 7 pointsize 0.8 linecolor rgb blue title "J^{T}, observed, ".transpose_penetration." inside", \
     csv using 1:8 skip 1 with points pointtype 6 pointsize 1.1 linewidth 1.5 linecolor rgb blue title "J^{T}, not observed", \
     csv using 1:5 skip 1 with points pointtype 2 pointsize 0.4 linewidth 1.2 linecolor rgb "black" title "ideal device", \
     csv using 1:6 skip 1 with points pointtype 2 pointsize 0.4 linewidth 1.2 linecolor rgb "black" notitle
