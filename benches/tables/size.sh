# Cost against the size of the pad

size() {
    tactus bench scenes/press/quadratic_coarse.ron --sizes 500,1000,2000,5000,10000 --threads 1 --repeat 1 -o "$OUT/size" > /dev/null
    tactus report "$OUT/size" -o "$OUT/size.html" | sed '1d; /^'"${OUT//\//\\/}"'/d'
}
