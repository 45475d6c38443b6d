#!/usr/bin/perl
# voronoid resample in this process: files, stdin and stdout, lines of JSON, the same bytes.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use POSIX ();
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(4000));
my $out = "$folder/out.ply";
my @request = ('-n', 500, '--iterations', 6, '--polish', 0);

sub count_of { return slurp($_[0]) =~ /^element vertex (\d+)$/m ? $1 : -1 }

my ($code, $stdout, $stderr) = run(['resample', $in, @request, '-fo', $out]);
is $code, 0, 'a cloud is resampled';
is $stdout, '', 'stdout stays empty';
like $stderr, qr/\Avoronoid: \Q$out\E: 500 points, delta 0\.\d{4} after 6 iterations, \d+\.\d s\n\z/,
    'one sentence says how it went, and no bar is drawn where there is no terminal';
is count_of($out), 500, 'there are exactly as many points as asked for';
is leftovers($folder, 'in.ply', 'out.ply'), '', 'no temporary file is left behind';
is sprintf('%o', (stat $out)[2] & 0777), sprintf('%o', 0666 & ~umask), 'it has the rights of a new file';
my $wanted = slurp($out);

($code, $stdout, $stderr) = run(['resample', $in, @request, '-fo', $out, '--quiet']);
is "$code|$stdout|$stderr", '0||', '--quiet is quiet';
(undef, undef, $stderr) = run(['resample', $in, @request, '--rho', 2, '-fo', $out]);
like $stderr, qr/^voronoid: \Q$out\E: warning: rho has an effect only with method=ear$/m, 'a parameter that changes nothing is warned of';

subtest 'stdin and stdout' => sub {
    my ($code, $stdout, $stderr) = run(['resample', '-', @request, '-fo', '-'], stdin => $in);
    is $code, 0, '- is stdin and stdout';
    ok $stdout eq $wanted, 'the bytes are those of the file';
    like $stderr, qr/\Avoronoid: -: 500 points/, 'the summary is not among them';
    ($code, $stdout, $stderr) = run(['resample', '-', @request, '-fo', '-', '--json'], stdin => $in);
    is $code, 0, '--json does not stop it';
    ok $stdout eq $wanted, 'the bytes are still alone on stdout';
    is scalar(split /\n/, $stderr), 8, 'the lines are on stderr';
    is decode_json((split /\n/, $stderr)[-1])->{points}{out}, 500, 'and the last is the report';
};

subtest 'what never ends and is no cloud' => sub {
    my ($code, undef, $stderr) = finish(start(['resample', '/dev/zero', @request, '-fo', $out]));
    is $code, 3, '/dev/zero is refused';
    like $stderr, qr{\Avoronoid: /dev/zero: the input begins with "\\x00}, 'by its first bytes';
    POSIX::mkfifo("$folder/pipe", 0600) or die "mkfifo: $!";
    my $reader = start(['resample', '-', @request, '-fo', $out], stdin => "$folder/pipe");
    open my $pipe, '>', "$folder/pipe" or die "$folder/pipe: $!";
    local $SIG{PIPE} = 'IGNORE';
    my $taken = 0;
    while ($taken < 1 << 24) { $taken += syswrite($pipe, 'x' x 4096) // last }
    close $pipe;
    unlink "$folder/pipe";
    ($code) = finish($reader);
    is $code, 3, 'also a pipe';
    cmp_ok $taken, '<', 1 << 20, 'of which no more is read';
};

subtest 'lines of JSON' => sub {
    my ($code, $stdout, $stderr) = run(['resample', $in, @request, '-fo', $out, '--json']);
    my @lines = split /\n/, $stdout;
    my @records = map { decode_json($_) } @lines;
    my $report = pop @records;
    is "$code$stderr", '0', 'all is well';
    is_deeply [map { $_->{iteration} } @records], [0 .. 6], 'there is a record for each iteration';
    my $shape = join ' ', sort qw(iteration polish delta sigma epsilon energy max_move held seconds run_stage step of ahead best quality angle mse);
    is_deeply [map { $_->{polish} } @records], [(0) x 7], 'none is of a polish that was not asked for';
    is join(' ', sort keys %$_), $shape, "record $_->{iteration} has its shape" for @records;
    cmp_ok $records[-1]{delta}, '<', $records[0]{delta}, 'delta falls';
    is $records[-1]{best}{delta}, $report->{delta}, 'the last best is the report\'s';
    is join(' ', sort keys %$report),
        join(' ', sort qw(points delta sigma epsilon iterations polish_steps stopped warnings stages seconds
            memory_peak_bytes invalid faces samples dropped outliers components islands lattice orientation one_sided ref_to_out out_to_ref mls_error boundary_points neighbors_histogram held held_ever fallbacks parameters area spacing min_over_mean max_over_mean
            six_share cells bisectors_per_cell triangles_per_cell queries list_rebuilds origin)), 'the report has its shape';
    is join(' ', sort keys %{ $report->{seconds} }), 'index init iterate polish read write', 'so have its seconds';
    is_deeply $report->{lattice}, { x => 0, y => 0, z => 0, moved => 0 }, 'it finds no lattice in a cloud without one';
    is "$report->{ref_to_out}{points} $report->{out_to_ref}{points}", '4000 500', 'it says from how many points distances are';
    cmp_ok $report->{ref_to_out}{mean}, '<=', $report->{ref_to_out}{rms}, 'a mean is at most the rms';
    is_deeply [map { $_->{neighbors} } @{ $report->{neighbors_histogram} }], [20], 'it says what surfaces were fitted to';
    my $fitted = 0;
    $fitted += $_->{points} for @{ $report->{neighbors_histogram} };
    is $fitted, 500, 'for every point';
    is $report->{polish_steps}, 0, 'it counts no step of a polish';
    is_deeply $report->{points}, { in => 4000, out => 500 }, 'it counts the points';
    is "$report->{iterations} $report->{stopped}", '6 iterations', 'it says why it stopped';
    is_deeply [map { "$_->{stage} $_->{steps}" } @{ $report->{stages} }], ['iterate 6'], 'and what it went through';
    cmp_ok $report->{seconds}{$_}, '>', 0, "it has the seconds of $_"
        for qw(read index init iterate write);
    cmp_ok abs($report->{area} - 12.566), '<', 0.3, 'it has the area of the sphere';
    is $report->{parameters}{$_->[0]}, $_->[1], "it has parameter $_->[0]"
        for ['points', 500], ['iterations', 6], ['format', 'ply'], ['neighbors', 20], ['seed', 1], ['polish', 0];
};

subtest 'the polish' => sub {
    my @polished = ('-n', 500, '--iterations', 6, '--polish', 40);
    my ($code, $stdout, $stderr) = run(['resample', $in, @polished, '-fo', "$folder/p.ply", '--json']);
    my @records = map { decode_json($_) } split /\n/, $stdout;
    my $report = pop @records;
    is "$code$stderr", '0', 'all is well';
    is count_of("$folder/p.ply"), 500, 'there are as many points as asked for';
    my @steps = map { $_->{polish} } @records;
    is_deeply [map { $_->{iteration} } grep { !$_->{polish} } @records], [0 .. 6], 'a record an iteration comes first';
    is_deeply \@steps, [sort { $a <=> $b } @steps], 'then those of the polish, in order';
    is scalar(grep { $_->{polish} && $_->{iteration} != 6 } @records), 0, 'which stay at the last iteration';
    is $steps[-1], $report->{polish_steps}, 'the last one has the steps of the report';
    cmp_ok $report->{polish_steps}, '<=', 40, 'there are no more than allowed';
    is $report->{parameters}{polish}, 40, 'which the report repeats';
    is_deeply [map { $_->{stage} } @{ $report->{stages} }], ['iterate', 'polish'], 'it went through both stages';
    is $report->{stages}[1]{seconds}, $report->{seconds}{polish}, 'with the seconds of each';
    my ($first) = grep { $_->{polish} } @records;
    is "$records[6]{run_stage} $records[6]{step} $records[6]{of} $records[6]{ahead}", 'iterate 6 6 40',
        'the last iteration knows what comes';
    is "$first->{run_stage} $first->{step} $first->{of} $first->{ahead}", 'polish 10 40 0', 'so does the polish';
    ($code, $stdout, $stderr) = run(['resample', $in, @polished, '-fo', "$folder/p.ply"]);
    my $counted = $report->{polish_steps} > 0 ? " and $report->{polish_steps} polish steps" : '';
    like $stderr, qr/ after 6 iterations$counted, \d+\.\d s\n\z/, 'the summary tells both';
    unlink "$folder/p.ply";
    my (undef, $all) = run(['resample', $in, '-n', 60, '--iterations', 2, '--json', '-fo', '/dev/null']);
    my (undef, $help) = run(['resample', '--help']);
    my ($default) = $help =~ /--polish VALUE\n(?: {6}.*\n)*? {6}.*default (\d+)\n/;
    is decode_json((split /\n/, $all)[-1])->{parameters}{polish}, $default, 'the default is that of the help';
};

subtest 'the same bytes' => sub {
    for my $threads (1, 2, 3, 8) {
        run(['resample', $in, @request, '-fo', "$folder/t.ply", '--threads', $threads, '-q']);
        ok slurp("$folder/t.ply") eq $wanted, "$threads threads make no difference";
    }
    run(['resample', $in, @request, '-fo', "$folder/t.ply", '-q'], env => { VORONOID_THREADS => 2 });
    ok slurp("$folder/t.ply") eq $wanted, 'nor does VORONOID_THREADS';
    run(['resample', $in, '--points=500', '--iterations=6', '--polish=0', "--output=$folder/t.ply", '-q']);
    ok slurp("$folder/t.ply") eq $wanted, 'nor does the way a value is written';
    run(['resample', '-n500', '--iterations', 6, '--polish', 0, "-fo$folder/t.ply", '-q', '--', $in]);
    ok slurp("$folder/t.ply") eq $wanted, 'nor does the order';
    run(['resample', $in, @request, '-fo', "$folder/t.ply", '-q', '--seed', 2]);
    ok slurp("$folder/t.ply") ne $wanted, 'another seed does';
    unlink "$folder/t.ply";
};

subtest 'the format' => sub {
    my @magic = ([ply => "ply\n"], [drc => 'DRACO']);
    for my $case (['a.ply', [], 'ply'], ['a.DRC', [], 'drc'], ['a', [], 'ply'],
        ['a.bin', ['--format', 'ply'], 'ply'], ['b.ply', ['--format', 'drc'], 'drc'], ['b.drc', ['--format=ply'], 'ply']) {
        my ($name, $option, $format) = @$case;
        my ($magic) = map { $_->[1] } grep { $_->[0] eq $format } @magic;
        my ($code, $stdout) = run(['resample', $in, @request, '-fo', "$folder/$name", '--json', @$option]);
        is $code, 0, "$name @$option is written";
        is substr(slurp("$folder/$name"), 0, length $magic), $magic, "$name @$option is $format";
        is decode_json((split /\n/, $stdout)[-1])->{parameters}{format}, $format, 'the report says so';
    }
    my ($code) = run(['resample', "$folder/a.DRC", '-n', 100, '-fo', "$folder/c", '-q']);
    is $code, 0, 'what was written is read';
    is substr(slurp("$folder/c"), 0, 5), 'DRACO', 'without a hint, the format is the input\'s';
    unlink "$folder/a", "$folder/c", glob "$folder/{a,b}.*";

    # A name that promises what is not written is refused before the input is looked at.
    for my $case (['a.las', '.las'], ['a.ply.gz', '.gz'], ['a.PLYX', '.PLYX']) {
        my ($name, $suffix) = @$case;
        my ($code, $stdout, $stderr) = run(['resample', "$folder/missing.ply", @request, '-fo', "$folder/$name"]);
        is "$code$stdout$stderr", "2voronoid: resample: the suffix of the output is $suffix, want one of .ply, .drc, or give "
            . "--format\n", "$name is refused";
        ok !-e "$folder/$name", 'and nothing is written';
    }
};

subtest 'what stands where the output goes' => sub {
    spew($out, 'old');
    my $bad = spew("$folder/bad.ply", 'x');
    my ($twin, $alias) = map { "$folder/$_.ply" } qw(twin alias);
    link $in, $twin and symlink $in, $alias or die;
    my $input = slurp($in);
    for my $case ([$in, $out, 'the file exists: use --force (-f) to overwrite it'], (map { [$in, $_, "the output is the input $in itself: give another output", '-f'] }
        $in, $twin, $alias), ['-', $twin, 'the output is the input on stdin itself: give another output', '-f']) {
        my ($from, $to, $line, @force) = @$case;
        my ($code, undef, $stderr) = run(['resample', $from, @request, @force, '-o', $to], stdin => $in);
        is "$code|$stderr", "2|voronoid: $to: $line\n", "$to is not written";
    }
    ok $input eq slurp($in) && slurp($out) eq 'old', 'and all is as it was';
    unlink $twin, $alias;
    run(['resample', $bad, '-n', 5, '-fo', $out]);
    is slurp($out), 'old', 'a failure leaves it alone';
    run(['resample', $in, @request, '-fo', $out, '-q']);
    ok slurp($out) eq $wanted, 'a success replaces it';
    spew("$folder/target.ply", 'old');
    symlink 'target.ply', "$folder/link.ply" or die;
    run(['resample', $in, @request, '-fo', "$folder/link.ply", '-q']);
    ok -l "$folder/link.ply" && slurp("$folder/target.ply") eq $wanted, 'a link is followed';
    my ($code) = run(['resample', $in, @request, '-fo', '/dev/null', '-q']);
    ok $code == 0 && -c '/dev/null', '/dev/null is written to, not replaced';
    my ($full, undef, $why) = run(['resample', $in, @request, '-fo', '/dev/full', '-q']);
    is "$full $why", "1 voronoid: /dev/full: cannot be written: No space left on device\n",
        'a full disk is told';
    ($full, undef, $why) = run(['resample', $in, @request, '-fo', '-', '-q'], stdout => '/dev/full');
    is "$full $why", "1 voronoid: -: cannot be written: No space left on device\n",
        'so is a full stdout';
    unlink map {"$folder/$_"} qw(bad.ply target.ply link.ply);
};

subtest 'a signal' => sub {
    my $big = spew("$folder/big.ply", sphere(20000));
    for my $case (['INT', 130], ['TERM', 4]) {
        my ($signal, $wanted) = @$case;
        my $process = start(['resample', $big, '-n', 20000, '--iterations', 10000, '--json', '-fo', "$folder/never.ply"]);
        ok((await { -s "$process->{folder}/out" }), 'it iterates');
        kill $signal, $process->{pid};
        my ($code, $stdout, $stderr) = finish($process);
        is $code, $wanted, "SIG$signal ends it with $wanted";
        my $kept = $signal eq 'INT' ? qr/^voronoid: stopping; the best result so far is written/ : qr/^voronoid: \Q$big\E: cancelled$/;
        like $stderr, $kept, 'it says so';
        is !!($stdout =~ /"points".*"stopped":"stopped"/), $signal eq 'INT', 'a report comes of ^C alone';
        is !!unlink("$folder/never.ply"), $signal eq 'INT', 'and so does a cloud';
    }
    unlink $big;
};
is leftovers($folder, 'in.ply', 'out.ply'), '', 'nothing is left behind';

subtest 'ratio and spacing' => sub {
    my ($code, $stdout) = run(['resample', $in, '--ratio', '0.1', '--iterations', 2, '--json', '-fo', $out]);
    is decode_json((split /\n/, $stdout)[-1])->{points}{out}, 400, 'ratio counts from the input';
    ($code, $stdout) = run(['resample', $in, '--spacing', '0.2', '--iterations', 20, '--json', '-fo', $out]);
    my $report = decode_json((split /\n/, $stdout)[-1]);
    cmp_ok abs($report->{points}{out} - 363), '<', 15, 'spacing counts from the area';
    cmp_ok abs($report->{spacing} / 0.2 - 1), '<', 0.1, 'and is what comes out';
};

done_testing;
