# Fig. 5: the device as a black circle inside a wall above it, and the forces that push it out.
set terminal svg size 900,800 font "DejaVu Sans,14" enhanced background rgb "white"
set size ratio -1
set label 1 heading at screen 0.5, 0.970 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.936 center noenhanced font ",12" textcolor rgb grey
set label 3 conditions at screen 0.5, 0.906 center noenhanced font ",12" textcolor rgb grey
set tmargin at screen 0.885
set bmargin at screen 0.27
set xlabel "outward force (N)"
set ylabel "upward force (N)"
set key at screen 0.5, 0.165 center top maxrows 4 samplen 2.5 spacing 1.3

span = 1.15 * longest_N
surface = -0.06 * span
set xrange [-span:span]
set yrange [-span:0.30*span]
set object 1 rectangle from -span,surface to span,0.30*span fillcolor rgb pale fillstyle solid noborder behind
set arrow 1 from -span,surface to span,surface nohead linewidth 2 linecolor rgb grey
set label 4 "wall, and the tip inside it (not to scale)" at graph 0.5, first 0.22*span center noenhanced textcolor rgb grey

plot csv using (0):(0):($7*span):($8*span) skip 1 every ::0::0 with vectors nohead linewidth 2 dashtype 3 linecolor rgb "black" title "correct direction", \
     csv using (0):(0):3:4 skip 1 every ::0::0 with vectors filled linewidth 3 linecolor rgb vermillion title "J^{-1}, observed, ".inverse_text, \
     csv using (0):(0):11:12 skip 1 every ::0::0 with vectors filled linewidth 1.5 dashtype 2 linecolor rgb vermillion title "not observed, ".inverse_unobserved_text, \
     csv using 5:6 skip 1 every ::0::0 with points pointtype 4 pointsize 1.3 linewidth 2 linecolor rgb vermillion title "predicted", \
     "+" using (0):(0) every ::0::0 with points pointtype 7 pointsize 1.8 linecolor rgb "black" title "device, ".penetration." inside", \
     csv using (0):(0):3:4 skip 1 every ::1::1 with vectors filled linewidth 3 linecolor rgb blue title "J^{T}, observed, ".transpose_text, \
     csv using (0):(0):11:12 skip 1 every ::1::1 with vectors filled linewidth 1.5 dashtype 2 linecolor rgb blue title "not observed, ".transpose_unobserved_text, \
     csv using 5:6 skip 1 every ::1::1 with points pointtype 6 pointsize 1.3 linewidth 2 linecolor rgb blue title "predicted"
