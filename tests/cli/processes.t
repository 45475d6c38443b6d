#!/usr/bin/perl
# voronoid denoise, upsample and simplify, here and by a daemon of our own: the same work as resample's, with a preset.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use HTTP::Tiny;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $http = HTTP::Tiny->new(timeout => 120);
my $points = 600;
my $in = spew("$folder/in.ply", sphere($points));
my $out = "$folder/out.ply";
my @brief = ('--iterations', 2, '--polish', 0, '-fo', $out);
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);

sub count_of { return slurp($_[0]) =~ /^element vertex (\d+)$/m ? $1 : -1 }
sub report_of { return decode_json((split /\n/, $_[0])[-1]) }
sub jobs { return @{ decode_json($http->get("$daemon->{url}/v1/jobs?limit=100")->{content})->{jobs} } }

# The cloud that came of it and the report, after a run that went well.
sub runs {
    my ($name, @arguments) = @_;
    unlink $out;
    my ($code, $stdout, $stderr) = run([@arguments, @brief, '--json']);
    is "$code$stderr", '0', "$name: all is well";
    return (slurp($out), report_of($stdout));
}

for my $case (
    ['denoise', [], $points, 1, 'drop', ['--ratio', 1, '--outliers', 'drop', '--filters', 'outliers,mls']],
    ['upsample', [], 4 * $points, 4, 'keep', ['--ratio', 4]],
    ['simplify', ['-n', 150], 150, undef, 'keep', ['-n', 150]],
) {
    my ($command, $given, $wanted, $ratio, $outliers, $same) = @$case;
    my ($bytes, $report) = runs($command, $command, $in, @$given);
    is count_of($out), $wanted, "$command: there are $wanted points";
    is_deeply $report->{points}, { in => $points, out => $wanted }, "$command: the report counts them";
    is $report->{parameters}{points}, $wanted, "$command: it has the points that came of the preset";
    is $report->{parameters}{ratio}, $ratio, "$command: the ratio";
    is $report->{parameters}{outliers}, $outliers, "$command: and outliers";
    my ($plain) = runs("$command by resample", 'resample', $in, @$same);
    ok $plain eq $bytes, "$command: resample does the same when told so";
    my ($there, $theirs) = runs("$command there", $command, $in, @$given, '--server', $daemon->{url});
    ok $there eq $bytes, "$command: so does a daemon";
    is_deeply $theirs->{parameters}, $report->{parameters}, "$command: with the same parameters";
    is +(jobs())[0]{processID}, $command, "$command: as a job of that process";
}

# What is said wins over the preset, here and there.
for my $server ([], ['--server', $daemon->{url}]) {
    my $where = @$server ? 'there' : 'here';
    my (undef, $report) = runs("denoise -n $where", 'denoise', $in, '-n', 100, '--outliers', 'keep', @$server);
    is count_of($out), 100, "denoise -n $where: as many points as asked for";
    is $report->{parameters}{outliers}, 'keep', "denoise -n $where: outliers are kept on request";
    ok !exists $report->{parameters}{ratio}, "denoise -n $where: there is no ratio beside the points";
    runs("upsample --ratio $where", 'upsample', $in, '--ratio', 1.5, @$server);
    is count_of($out), 900, "upsample --ratio $where: as many points as asked for";
    runs("simplify --spacing $where", 'simplify', $in, '--spacing', 0.3, @$server);
    cmp_ok abs(count_of($out) - 161), '<', 20, "simplify --spacing $where: as many as that makes";
}

# Refused by the daemon as here.
unlink $out;
for my $case (
    [['simplify', '-n', 601], qr/points is 601, want 1 to 600: simplify cannot give more points than the input has \(600\)$/],
    [['upsample', '-n', 599], qr/points is 599, want 600 to 9600: the result of upsample may have 1 to 16 times as many points as the input \(600\)$/],
    [['simplify', '--spacing', 0.1], qr/spacing is 0\.1 and needs 1\d\d\d points, want 1 to 600: simplify /],
) {
    my ($request, $why) = @$case;
    my ($command, @given) = @$request;
    for my $server ([], ['--server', $daemon->{url}]) {
        my ($code, $stdout, $stderr) = run([$command, $in, @given, @brief, @$server]);
        is "$code$stdout", '3', "@$request @$server: the exit code is 3";
        like $stderr, qr/\Avoronoid: \Q$in\E: [^\n]*\n\z/, "@$request @$server: one line";
        like $stderr, $why, "@$request @$server: names value and range";
        ok !-e $out, "@$request @$server: nothing is written";
    }
}
is leftovers($folder, qw(data in.ply)), '', 'nothing is left behind';
is +(stop($daemon))[0], 0, 'the daemon ends with 0';
done_testing;
