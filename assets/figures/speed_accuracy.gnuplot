# A speed-accuracy chart: cost and error of each method. Columns of the CSV file: method, setting,
# minimum, median and maximum cost [ns], error, stable.
rows = (words(legend) + has_failures + 1) / 2 # of the legend
row = 20.0                      # pixels
height = 600 + row*rows
set terminal svg size 900,height font "DejaVu Sans,14" enhanced background rgb "white"
set label 1 heading at screen 0.5, 0.965 center noenhanced font ",16"
set label 2 footnote at screen 0.5, 0.925 center noenhanced font ",11" textcolor rgb grey
set tmargin at screen 0.89
set bmargin at screen (118 + row*rows)/height
set lmargin at screen 0.14
set rmargin at screen 0.97
set logscale xy
set xrange [cost_low_s:cost_high_s]
set yrange [error_low:error_high]
set xlabel cost_label noenhanced
# A long label takes two lines, to stay within the frame.
comma = strstrt(error_label, ", ")
if (strlen(error_label) > 55 && comma > 0) {
    error_label = error_label[1:comma] . "\n" . error_label[comma + 2:*]
}
set ylabel error_label noenhanced
# Narrower than gnuplot takes the longest text to be.
set key at screen 0.52, (34 + row*rows)/height center top maxrows rows samplen 2.5 width -5 font ",12" noenhanced Left reverse

# Each decade has a number; with few decades, 2 and 5 as well.
set micro
set xtics format "%.0s %cs"
few(low, high) = log10(high/low) < 2.2
if (few(cost_low_s, cost_high_s)) {
    set for [e=-12:3] for [m in "2 5"] xtics add (gprintf("%.0s %cs", m*10.0**e) m*10.0**e)
}
least = error_of_zero > 0 ? 10*error_of_zero : error_low # except 0
plain = least > 5e-5 && error_high < 5e4
power = "10^{%T}"
set ytics format (plain ? "%g" : power)
if (few(least, error_high)) {
    set for [e=-20:6] for [m in "2 5"] ytics add (gprintf(plain ? "%g" : "%.0t·".power, m*10.0**e) m*10.0**e)
}
# An error of 0 or of round-off is drawn below all others, with its own tic.
if (error_of_zero > 0) {
    set ytics ((round_off > 0 ? "≈ 0" : "0") error_of_zero)
    do for [e=-20:6] {
        if (10.0**e > 5*error_of_zero) { set ytics add (gprintf(plain ? "%g" : power, 10.0**e) 10.0**e) }
    }
}

# One colour and one mark per method.
array colour[10] = [vermillion, blue, green, "#CC79A7", "#E69F00", "black", "#56B4E9", "#8C564B", "#777777", "#B2A000"]
array mark[10] = [4, 7, 8, 12, 6, 10, 5, 9, 13, 11]
count = words(legend)
look(i) = (i - 1) % 10 + 1

method_of(row) = word(method_of_rows, int(row) + 1)

# A point is at the minimum of its times, which other load affects least; a bar extends to the
# maximum. For method i in the current row; undefined values are omitted.
is_of(i) = method_of($0) == i
stable(i) = is_of(i) && $7 == 1 ? 1e-9*$3 : NaN
unstable(i) = is_of(i) && $7 == 0 ? 1e-9*$3 : NaN
error(row) = !valid(6) ? error_of_none : $6 <= round_off ? error_of_zero : $6

# The first point of a method is larger.
size(row) = row > 0 && method_of(row) eq method_of(row - 1) ? 0.9 : 1.4

failure = !has_failures ? "" : error_of_none > 0 ? "fails (at the top: no error measured)" : "fails"
plot for [i=1:count] csv using (stable(i)):(error($0)):(1e-9*$3):(1e-9*$5) skip 1 with xerrorbars pointtype 0 linewidth 0.7 linecolor rgb colour[look(i)] notitle, \
     for [i=1:count] csv using (stable(i)):(error($0)):(size($0)) skip 1 with linespoints pointtype mark[look(i)] pointsize variable linewidth 1.5 linecolor rgb colour[look(i)] title word(legend, i), \
     for [i=1:count] csv using (unstable(i)):(error($0)):(1.5*size($0)) skip 1 with points pointtype 2 pointsize variable linewidth 3 linecolor rgb colour[look(i)] notitle, \
     NaN with points pointtype 2 pointsize 1.4 linewidth 3 linecolor rgb grey title failure
