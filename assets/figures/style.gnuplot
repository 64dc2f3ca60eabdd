# Settings of all charts; app/figures/figure.h documents where csv, svg and the marks come from.
# Colour-blind safe colours (Okabe and Ito), on white, for print.
set encoding utf8
set minussign
set datafile separator ","
set output svg
blue = "#0072B2"
vermillion = "#D55E00"
green = "#009E73"
grey = "#777777"
pale = "#DDDDDD"
set border linewidth 1
set tics nomirror out
set grid linecolor rgb pale linewidth 0.5
