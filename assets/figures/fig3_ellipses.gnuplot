# Fig. 3: the linkage, and about its tip the ellipse and the circle inscribed.
set terminal svg size 900,860 font "DejaVu Sans,14" enhanced background rgb "white"
set size ratio -1
set label 1 heading at screen 0.5, 0.972 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.940 center noenhanced font ",12" textcolor rgb grey
set label 6 conditions at screen 0.5, 0.912 center noenhanced font ",12" textcolor rgb grey
set tmargin at screen 0.885
set bmargin at screen 0.22
set xlabel "outward from the base joint (mm)"
set ylabel "up from the base joint (mm)"
set key at screen 0.5, 0.115 center top maxrows 3 samplen 2 spacing 1.3

reach = sqrt(tip_x**2 + tip_y**2) * 0.9
low_x = -0.35*reach;  high_x = (tip_x > elbow_x ? tip_x : elbow_x) + 0.65*reach
low_y = (tip_y < 0 ? tip_y : 0) - 0.7*reach;  high_y = (elbow_y > 0 ? elbow_y : 0) + 0.5*reach
set xrange [low_x:high_x]
set yrange [low_y:high_y]

# The linkage: upper arm, forearm, and the crank and rod that turn it.
set arrow 1 from 0,0 to elbow_x,elbow_y nohead linewidth 6 linecolor rgb grey
set arrow 2 from elbow_x,elbow_y to tip_x,tip_y nohead linewidth 6 linecolor rgb grey
set arrow 3 from 0,0 to crank_x,crank_y nohead linewidth 3 linecolor rgb grey
set arrow 4 from crank_x,crank_y to coupling_x,coupling_y nohead linewidth 3 linecolor rgb grey

# The scale of stiffness.
bar = bar_N_per_m * mm_per_N_per_m
bar_x = low_x + 0.06*(high_x - low_x)
bar_y = low_y + 0.07*(high_y - low_y)
set arrow 5 from bar_x,bar_y to bar_x + bar,bar_y heads size screen 0.006,90 linewidth 2 linecolor rgb "black"
set label 3 bar_text at bar_x + 0.5*bar, bar_y center offset 0,0.7

plot csv using (tip_x + mm_per_N_per_m*$2):(tip_y + mm_per_N_per_m*$3) skip 1 with lines linewidth 3 linecolor rgb vermillion title "K^{inv} (21), semi-axes ".shortest_text." and ".longest_text." N/mm", \
     csv using (tip_x + mm_per_N_per_m*$4):(tip_y + mm_per_N_per_m*$5) skip 1 with lines linewidth 3 linecolor rgb blue title "K^{trans} (27), ".circle_text." N/mm at α ".alpha_text." rad²/m²", \
     csv using (tip_x + mm_per_N_per_m*$6):(tip_y + mm_per_N_per_m*$7) skip 1 with points pointtype 5 pointsize 0.8 linecolor rgb vermillion title "J^{-1}, measured", \
     csv using (tip_x + mm_per_N_per_m*$8):(tip_y + mm_per_N_per_m*$9) skip 1 with points pointtype 7 pointsize 0.8 linecolor rgb blue title "J^{T}, measured", \
     "+" using (0):(0) every ::0::0 with points pointtype 7 pointsize 1.6 linecolor rgb grey notitle, \
     "+" using (elbow_x):(elbow_y) every ::0::0 with points pointtype 7 pointsize 1.2 linecolor rgb grey notitle, \
     "+" using (tip_x):(tip_y) every ::0::0 with points pointtype 7 pointsize 0.9 linecolor rgb "black" title "tip"
