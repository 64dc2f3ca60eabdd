# The tip's speed after trials over two parameters, with the predicted limit and the limit up to
# which trials come to rest.
set terminal svg size 900,760 font "DejaVu Sans,14" enhanced background rgb "white"
set lmargin at screen 0.13
set rmargin at screen 0.82
set tmargin at screen 0.85
set bmargin at screen 0.11
set label 1 heading at screen 0.5, 0.97 center noenhanced font ",16"
set label 2 setting at screen 0.5, 0.935 center noenhanced font ",11" textcolor rgb grey
set label 3 loop at screen 0.5, 0.91 center noenhanced font ",11" textcolor rgb grey

# The grid is uniform in x or in its logarithm; tics show the values themselves.
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
# By trial: half-way between cells that are stable (1) and not (0).
set cntrparam levels discrete 0.5
set table $by_trial
splot csv using (along_x($1)):(along_y($2)):4 skip 1
unset table
set surface
unset contour

set xrange [x_first:x_last]
set yrange [y_first:y_last]
# A number at each decade, or where there are many at each second, third, ...; where there are few, at 2 and 5 or at every digit as well.
power(v) = v < 1e-3 || v > 1e5 ? gprintf("10^{%T}", v) : sprintf("%g", v)
number(m, d) = m == 1 ? power(10.0**d) : d < -3 ? sprintf("%d·%s", m, power(10.0**d)) : sprintf("%g", m * 10.0**d)
is_told(m, d, width) = m == 1 ? d % ceil(width/12) == 0 : width < 1.05 || width < 2.5 && (m == 2 || m == 5)
if (x_by_ratio) {
    set xtics (" " -99) # no default tics
    set for [d=-12:7] for [m=1:9] xtics add ((is_told(m, d, x_last - x_first) ? number(m, d) : "") d + log10(m) m > 1)
}
if (y_by_ratio) {
    set ytics (" " -99)
    set for [d=-12:7] for [m=1:9] ytics add ((is_told(m, d, y_last - y_first) ? number(m, d) : "") d + log10(m) m > 1)
}
set xlabel x_label
set ylabel y_label offset 1,0
set cblabel "tip's speed a second after release (mm/s)" offset 1,0
set logscale cb
set cbrange [1:1000]
set cbtics ("≤ 1" 1, "10" 10, "100" 100, "≥ 1000" 1000)
set palette defined (0 "#f7fbff", 0.25 "#9ecae1", 0.45 "#4292c6", 0.55 "#fdae6b", 0.8 "#d94801", 1 "#7f2704")
unset grid
set key at screen 0.82, 0.893 right top horizontal samplen 3 font ",11"
set datafile separator whitespace # as tables are
# If there is no line, the legend says so.
plot $field using 1:2:3 with image pixels notitle, \
     $predicted using 1:2 with lines linewidth 4 linecolor rgb "white" notitle, \
     $by_trial using 1:2 with lines linewidth 3.4 linecolor rgb "white" notitle, \
     $by_trial using 1:2 with lines linewidth 1.6 dashtype (6,4) linecolor rgb "#006d2c" notitle, \
     $predicted using 1:2 with lines linewidth 2.2 linecolor rgb "black" notitle, \
     NaN with lines linewidth (strlen(no_predicted_line) ? 0 : 2.2) linecolor rgb "black" title (strlen(no_predicted_line) ? no_predicted_line : "predicted: largest eigenvalue 1"), \
     NaN with lines linewidth (strlen(no_trial_line) ? 0 : 1.6) dashtype (6,4) linecolor rgb "#006d2c" title (strlen(no_trial_line) ? no_trial_line : "by trial: rest or no rest")
