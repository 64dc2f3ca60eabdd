# The tip's speed that trials leave behind over two parameters, with the predicted line on it.
set terminal svg size 900,760 font "DejaVu Sans,14" enhanced background rgb "white"
set lmargin at screen 0.12
set rmargin at screen 0.82
set tmargin at screen 0.88
set bmargin at screen 0.11
set label 1 heading at screen 0.5, 0.965 center font ",16"
set label 2 setting at screen 0.5, 0.925 center noenhanced font ",11" textcolor rgb grey

# The grid is even in x or in its logarithm; tics say the values themselves.
along_x(v) = x_by_ratio ? log10(v) : v
along_y(v) = y_by_ratio ? log10(v) : v

set table $field
plot csv using (along_x($1)):(along_y($2)):(1000 * $5 < 1 ? 1 : 1000 * $5) skip 1 with table
unset table

# The predicted line: where the largest eigenvalue is 1.
set contour base
set cntrparam levels discrete 1.0
unset surface
set table $predicted
splot csv using (along_x($1)):(along_y($2)):3 skip 1
unset table
set surface
unset contour

set xrange [x_first:x_last]
set yrange [y_first:y_last]
if (x_by_ratio) {
    set xtics (" " -99) # none of its own
    set for [d=-12:7] for [m=1:9] xtics add ((m == 1 || (m == 2 || m == 5) && x_last - x_first < 2.5) ? sprintf("%g", m * 10.0**d) : "" d + log10(m) m > 1)
}
if (y_by_ratio) {
    set ytics (" " -99)
    set for [d=-12:7] for [m=1:9] ytics add ((m == 1 || (m == 2 || m == 5) && y_last - y_first < 2.5) ? sprintf("%g", m * 10.0**d) : "" d + log10(m) m > 1)
}
set xlabel x_label
set ylabel y_label offset 1,0
set cblabel "tip's speed a second after it was let go (mm/s; up to 1000)" offset 1,0
set logscale cb
set cbrange [1:1000]
set format cb "%g"
set palette defined (0 "#f7fbff", 0.25 "#9ecae1", 0.45 "#4292c6", 0.55 "#fdae6b", 0.8 "#d94801", 1 "#7f2704")
unset grid
set key at screen 0.82, 0.905 right top horizontal samplen 3
set datafile separator whitespace # as tables are
plot $field using 1:2:3 with image pixels notitle, \
     $predicted using 1:2 with lines linewidth 4 linecolor rgb "white" notitle, \
     $predicted using 1:2 with lines linewidth 2.2 linecolor rgb "black" title "predicted: largest eigenvalue 1"
