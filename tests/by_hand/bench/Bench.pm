package Bench;

# What the benchmark's scripts share: clouds, timed runs, the yardstick, what was asked, tables, plots.
use strict;
use warnings;
use utf8;
use Exporter 'import';
use JSON::PP;

our @EXPORT = qw(begin runs wanted public made torus yardstick program resample process timed quality against median spread number judge remember
    missing table finish plot);

binmode STDOUT, ':encoding(UTF-8)';
my $shared = '../shared';
my $yardstick = "$shared/yardstick/metrics.py";
my $runs = $ENV{RUNS} || 5;
my $only = $ENV{ONLY} // '';
my ($binary, $out, $text, %seen);

# usage: SCRIPT VORONOID OUTDIR
sub begin {
    my ($title) = @_;
    ($binary, $out) = @ARGV;
    die "usage: $0 VORONOID OUTDIR\n" unless defined $out;
    $text = "# $title\n\n";
    return $out;
}

sub runs { return $runs }
sub wanted { my ($name) = @_; return $only eq '' || $name =~ /$only/ }

# Paths: a public cloud, one that the yardstick makes, the yardstick, a torus of n points made here.
sub public { return "$shared/data/$_[0].ply" }
sub yardstick { return $yardstick }
sub made { return "$out/clouds/$_[0].ply" }

sub torus {
    my ($n) = @_;
    my $path = made("torus$n");
    return $path if -e $path;
    system(program('torus'), $n, "$path.new") == 0 or die "no torus of $n points\n";
    rename "$path.new", $path or die "$path: $!\n";
    return $path;
}

# A program of the benchmark's own, beside the binary.
sub program { my ($name) = @_; return $binary =~ s{[^/]+$}{tests/by_hand/bench/$name}r }

sub slurp {
    my ($path) = @_;
    open my $in, '<', $path or die "$path: $!\n";
    local $/;
    return scalar <$in>;
}

# Runs a command: what it printed, line by line, and its CPU seconds, wall seconds and peak memory in MB.
sub timed {
    my (@command) = @_;
    my $log = "$out/time.$$";
    open my $from, '-|', 'time', '-f', '%U %S %e %M', '-o', $log, @command or die "time: $!\n";
    my @lines = <$from>;
    close $from or die "@command: failed\n";
    my ($user, $system, $wall, $kb) = split ' ', slurp($log);
    unlink $log;
    return { lines => \@lines, cpu => $user + $system, wall => $wall, rss => $kb / 1024 };
}

# One run of a process: the report, the records, and the figures that rows are made of.
sub resample { return process('resample', @_) }

sub process {
    my ($process, $input, $result, @arguments) = @_;
    my $run = timed($binary, $process, $input, @arguments, '--json', '-f', '-o', $result);
    my @objects = map { decode_json($_) } @{ $run->{lines} };
    my $report = pop @objects;
    my $seconds = $report->{seconds};
    my ($n, $iterations, $steps) = ($report->{points}{out}, $report->{iterations}, $report->{polish_steps} // 0);
    $seconds->{polish} //= 0;
    my %run = (%$run, report => $report, records => \@objects, iterations => $iterations, steps => $steps);
    $run{engine} = 0;
    $run{engine} += $seconds->{$_} for qw(index init iterate polish);
    $run{us_iteration} = $seconds->{iterate} / $iterations / $n * 1e6 if $iterations > 0;
    my $cpu_over_clock = $run->{cpu} / ($run{engine} + $seconds->{read} + $seconds->{write});
    $run{cpu_us} = $run{us_iteration} * $cpu_over_clock if $iterations > 0;
    $run{us_step} = $seconds->{polish} / $steps / $n * 1e6 if $steps > 0;
    return \%run;
}

# What the yardstick says of a result against the true mesh.
sub quality {
    my ($result, $truth) = @_;
    open my $from, '-|', '/usr/bin/python3', $yardstick, $result, '--mesh', $truth or die "python3: $!\n";
    my $measured = decode_json(join '', <$from>);
    close $from or die "$yardstick $result: failed\n";
    my $mesh = $measured->{mesh};
    return (
        n => $measured->{n}, coincident => $measured->{coincident}, delta => $measured->{delta}, hex => $mesh->{hex},
        gap_max => $mesh->{gap_max}, off_surface_rms => $mesh->{off_surface_rms},
    );
}

# What the yardstick says of a result beside its input, and where there is a truth, of the mesh.
sub against {
    my ($result, $input, $truth) = @_;
    open my $from, '-|', '/usr/bin/python3', $yardstick, $result, '--input', $input, $truth ? ('--mesh', $truth) : ()
        or die "python3: $!\n";
    my $measured = decode_json(join '', <$from>);
    close $from or die "$yardstick $result: failed\n";
    my ($even, $mesh) = ($measured, $measured->{mesh} // {});
    return (
        map({ $_ => $even->{$_} } qw(n coincident delta)), far => $measured->{input}{far_over_knn6_p999},
        map({ $_ => $mesh->{$_} } qw(off_surface_rms off_surface_mean off_surface_max)),
    );
}

sub median {
    my @sorted = sort { $a <=> $b } grep { defined } @_;
    return @sorted ? $sorted[$#sorted / 2] : undef;
}

sub number {
    my ($value) = @_;
    return '-' unless defined $value;
    return $value =~ /^\d+$/ ? $value : sprintf '%.3g', $value;
}

# "median ± half the range" of one figure over some runs; the figure alone of one.
sub spread {
    my ($figure, @runs) = @_;
    my @sorted = sort { $a <=> $b } grep { defined } map { $_->{$figure} } @runs;
    return number($sorted[0]) if @sorted < 2;
    return sprintf '%.3g ± %.2g', $sorted[$#sorted / 2], ($sorted[-1] - $sorted[0]) / 2;
}

# Rows that later conditions refer to as row.figure.
sub remember { my ($name, $row) = @_; $seen{$name} = $row; return }

# Conditions such as "delta <= 0.03" beside what became of them; ? where a figure was not measured.
sub judge {
    my ($row, @conditions) = @_;
    my @said;
    for my $condition (@conditions) {
        my ($figure, $how, $bound) = split ' ', $condition;
        $bound = $seen{$1}{$2} if $bound =~ /^([a-z]\w*)\.(\w+)$/;
        my $value = $row->{$figure};
        my $met = !defined $value || !defined $bound ? '?'
            : ($how eq '<=' ? $value <= $bound : $value >= $bound) ? '✓' : '✗';
        push @said, "$condition $met";
    }
    return @said ? join('; ', @said) : '-';
}

# The first of some files that is not here, as a row says it; nothing when all are.
sub missing {
    my ($name, @files) = @_;
    my ($absent) = grep { !-r } @files;
    return $absent ? "$name: not measured, $absent is not here" : undef;
}

sub table {
    my ($columns, $rows, $sentence) = @_;
    return unless @$rows;
    $text .= '| ' . join(' | ', @$columns) . " |\n" . '|---' x @$columns . "|\n";
    $text .= '| ' . join(' | ', ref $_ ? @$_ : $_) . " |\n" for @$rows;
    $text .= "\n$sentence\n\n";
    return;
}

sub first_line {
    my (@command) = @_;
    open my $from, '-|', @command or return 'not known';
    my $line = <$from> // 'not known';
    close $from;
    chomp $line;
    return $line;
}

# Where and how it was measured, and the page as NAME.md and on standard output.
sub finish {
    my ($name) = @_;
    my ($cpu) = slurp('/proc/cpuinfo') =~ /^model name\s*:\s*(.+)$/m;
    my @day = localtime;
    $text .= join ', ', 'Commit ' . first_line(qw(git describe --always --dirty)), first_line(qw(gcc --version)),
        '-O3 -ffp-contract=off (CGAL -O3)', $cpu // 'unknown CPU', first_line('nproc') . ' cores',
        sprintf('%d-%02d-%02d', $day[5] + 1900, $day[4] + 1, $day[3]),
        $runs > 1 ? "$runs runs after a warm-up: median ± half the range.\n\n" : "one run.\n\n";
    open my $page, '>:encoding(UTF-8)', "$out/$name.md" or die "$out/$name.md: $!\n";
    print $page $text;
    close $page;
    print $text;
    return;
}

# NAME.svg and its figures in NAME.dat; a series is a title, a style and rows of numbers.
sub plot {
    my ($name, $settings, @series) = @_;
    my $data = "$out/$name.dat";
    open my $dat, '>:encoding(UTF-8)', $data or die "$data: $!\n";
    print $dat map { ("# $_->{title}\n", map({ "@$_\n" } @{ $_->{rows} }), "\n\n") } @series;
    close $dat;
    my @lines = map { "'$data' index $_ with $series[$_]{style} title '$series[$_]{title}'" } 0 .. $#series;
    my @style = (
        "terminal svg size 900,600 enhanced background 'white'", 'encoding utf8', "output '$out/$name.svg'", 'grid',
        'key noenhanced outside below vertical maxcols 2 Left reverse',
    );
    open my $gnuplot, '|-:encoding(UTF-8)', 'gnuplot' or die "gnuplot: $!\n";
    print $gnuplot map({ "set $_\n" } @style, @$settings), 'plot ', join(', ', @lines), "\n";
    close $gnuplot or die "$name.svg: gnuplot failed\n";
    $text .= "![$name]($name.svg)\n\n";
    return;
}

1;
