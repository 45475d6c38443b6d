#!/usr/bin/perl
# Filters on the command line and over HTTP: what comes of them alone, and what is refused.
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
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);

sub count_of { return slurp($_[0]) =~ /^element vertex (\d+)$/m ? $1 : -1 }

# The cloud that came of it and the report, after a run that went well.
sub runs {
    my ($name, @arguments) = @_;
    unlink $out;
    my ($code, $stdout, $stderr) = run([@arguments, '-fo', $out, '--json']);
    is "$code$stderr", '0', "$name: all is well";
    return (slurp($out), decode_json((split /\n/, $stdout)[-1]));
}

for my $case (['denoise', 'mls', $points], ['resample', 'mls', $points], ['simplify', 'thin,mls', undef],
    ['upsample', 'mls', 4 * $points]) {
    my ($command, $filters, $wanted) = @$case;
    my @brief = $command eq 'upsample' ? ('--iterations', 1, '--polish', 0) : ();
    my ($bytes, $report) = runs("$command $filters", $command, $in, '--filters', $filters, @brief);
    is count_of($out), $wanted // $report->{points}{out}, "$command $filters: as many points as there should be";
    cmp_ok $report->{points}{out}, '<', $points, "$command $filters: fewer, thinned" if !defined $wanted;
    is_deeply $report->{parameters}{filters}, [$filters =~ /thin/ ? qw(mls thin) : 'mls'], "$command: the report has them";
    is scalar @{ $report->{stages} }, $command eq 'upsample' ? 1 : 0, "$command: and the stages there were";
    ok !exists $report->{parameters}{points}, "$command: nobody asked for points" if $command ne 'upsample';
    my ($there, $theirs) = runs("$command there", $command, $in, '--filters', $filters, @brief, '--server', $daemon->{url});
    ok $there eq $bytes, "$command: a daemon does the same";
    is_deeply $theirs->{parameters}, $report->{parameters}, "$command: with the same parameters";
}

my ($code, $stdout, $stderr) = run(['denoise', $in, '--filters', 'mls', '-fo', $out]);
like $stderr, qr/: 600 points, delta [\d.]+, [\d.]+ s$/m, 'the summary names no steps where nothing was spread';

my $job = $http->post("$daemon->{url}/v1/denoise?filters=mls,outliers&outliers=pull&format=ply", { content => slurp($in) });
is $job->{status}, 200, 'a request over HTTP works';
is $job->{content} =~ /^element vertex (\d+)$/m ? $1 : -1, $points, 'and gives as many points as it got';

# An unknown word, and thin, which says nothing of a number of points.
($code, $stdout, $stderr) = run(['denoise', $in, '--filters', 'mls,blur', '-fo', $out]);
is $code, 2, 'an unknown filter is refused as a wrong parameter';
like $stderr, qr/filters is "mls,blur", want words separated by commas, each at most once: mls, outliers, thin, or none/, 'with the list';
my $refused = $http->post("$daemon->{url}/v1/denoise?filters=blur", { content => slurp($in) });
is $refused->{status}, 422, 'over HTTP as a request that can be read but not followed';
like decode_json($refused->{content})->{detail}, qr/^filters is "blur", want words separated by commas, each at most once: mls, outliers, thin, or none/, 'with the list';
($code, $stdout, $stderr) = run(['resample', $in, '--filters', 'thin', '-fo', $out]);
like $stderr, qr/points, ratio and spacing: none is given/, 'thin alone says nothing of a number of points';

stop($daemon);
done_testing();
