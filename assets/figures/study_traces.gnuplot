# The course of a method with one participant, a panel a condition; see app/commands/study/study_analyse.cpp.
# Columns of traces.csv: participant, condition, block, trial, track, level, positive, setting,
# marked, reversal, threshold, its low and high end.
columns = panels > 1 ? 2 : 1
rows = (int(panels) + columns - 1)/columns
width = 40.0 + 460*columns
height = 130.0 + 335*rows
set terminal svg size width,height font "DejaVu Sans,13" enhanced background rgb "white"
set multiplot layout rows,columns margins screen 80/width,(width - 25)/width,95/height,(height - 95)/height spacing screen 95/width,105/height
set label 1 heading at screen 0.5,(height - 25)/height center noenhanced font ",16"
set label 2 note at screen 0.5,(height - 50)/height center noenhanced font ",11" textcolor rgb grey
set xlabel "trial" offset 0,0.3
# Where it is however wide the numbers are.
set label 4 level_label at graph 0,0.5 center rotate by 90 offset -7.2,0 noenhanced
set autoscale xfix
set autoscale yfix
set offsets graph 0.02,graph 0.02,graph 0.08,graph 0.08
set key at screen 0.5,25/height center center maxrows 1 samplen 2 width -3 noenhanced
array colour[4] = [blue, vermillion, green, "#CC79A7"]
colour_of(track) = colour[(track - 1) % 4 + 1]
right(level) = $7 == 1 ? level : NaN
wrong(level) = $7 == 0 ? level : NaN
do for [i=1:panels] {
    set label 3 value(sprintf("title_%d", i)) at graph 0.5,1.06 center noenhanced font ",14"
    f = value(sprintf("traces_first_%d", i))
    l = value(sprintf("traces_last_%d", i))
    if (is_logarithmic) {
        # All that is drawn: levels, and settings or the threshold with its ends.
        unset logscale y
        low = 1e99
        high = 0
        do for [c in (is_adjustment ? "6 8" : tracks > 0 ? "6" : "6 12 13")] {
            stats csv using (column(int(c))) skip 1 every ::f::l nooutput name "of"
            if (of_records > 0) {
                low = of_min < low ? of_min : low
                high = of_max > high ? of_max : high
            }
        }
        set logscale y
        eval log_tics("y", low, high, 11)
    }
    if (is_adjustment) {
        plot csv using 4:6 skip 1 every ::f::l with points pointtype 6 pointsize 0.6 linecolor rgb grey title "start", \
             csv using 4:8 skip 1 every ::f::l with linespoints pointtype 7 pointsize 0.8 linecolor rgb blue title "setting", \
             csv using 4:($9 == 1 ? $6 : NaN) skip 1 every ::f::l with points pointtype 2 pointsize 0.8 linecolor rgb grey title "marked"
    } else {
        if (tracks > 0) {
            set datafile missing NaN
            plot for [k=1:tracks] csv using ($5 == k && $9 == 0 ? $4 : NaN):6 skip 1 every ::f::l with lines linewidth 1 linecolor rgb colour_of(k) title (tracks > 1 ? sprintf("track %d", k) : "track"), \
                 csv using 4:(right($6)) skip 1 every ::f::l with points pointtype 7 pointsize 0.55 linecolor rgb "black" title "right", \
                 csv using 4:(wrong($6)) skip 1 every ::f::l with points pointtype 6 pointsize 0.6 linewidth 1.2 linecolor rgb "black" title "wrong", \
                 csv using 4:($10 == 1 ? $6 : NaN) skip 1 every ::f::l with points pointtype 6 pointsize 1.3 linecolor rgb green title "reversal", \
                 csv using 4:($9 == 1 ? $6 : NaN) skip 1 every ::f::l with points pointtype 2 pointsize 0.8 linecolor rgb grey title "marked"
        } else {
            plot csv using 4:12:13 skip 1 every ::f::l with filledcurves fillcolor rgb blue fillstyle transparent solid 0.18 noborder title "± SD", \
                 csv using 4:11 skip 1 every ::f::l with lines linewidth 2 linecolor rgb blue title "threshold so far", \
                 csv using 4:(right($6)) skip 1 every ::f::l with points pointtype 7 pointsize 0.55 linecolor rgb "black" title "right", \
                 csv using 4:(wrong($6)) skip 1 every ::f::l with points pointtype 6 pointsize 0.6 linewidth 1.2 linecolor rgb "black" title "wrong", \
                 csv using 4:($9 == 1 ? $6 : NaN) skip 1 every ::f::l with points pointtype 2 pointsize 0.8 linecolor rgb grey title "marked"
        }
    }
    unset key
    unset label 1
    unset label 2
}
unset multiplot
