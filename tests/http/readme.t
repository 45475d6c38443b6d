#!/usr/bin/perl
# The blocks of README.md and of the help's topics, word for word and in the order printed, against the real daemon. Between it and
# its clients stands a recorder, on the port that the blocks name: what each request was answered, its status and its media type, is
# what openapi.yaml says; JSON has the members described. Those for proxies are run by `make proxy`, the two commands by continuous integration; docker's, a daemon before which
# a proxy stands, and other people's programs by nobody here.
use strict;
use warnings;
use Cwd qw(abs_path);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Contract;
use IO::Socket::INET;
use Recorder;
use Test::More;
use Vt;

my $readme = Vt::slurp('README.md');
my @blocks = Vt::documented();
my %run = (
    sh => sub { $_[0] },
    js => sub { "cat >block.mjs <<'END_OF_BLOCK'\n$_[0]END_OF_BLOCK\nnode block.mjs\n" },
    ini => sub { "cat >block.conf <<'END_OF_BLOCK'\n$_[0]END_OF_BLOCK\nvoronoid serve --check-config --config block.conf\n" },
    python => sub { "python3 - <<'END_OF_BLOCK'\n$_[0]END_OF_BLOCK\n" },
);
my %elsewhere = map { $_ => 1 } qw(nginx haproxy caddyfile console);
my %least = ('README.md' => 4, examples => 5, http => 3, data => 2, keys => 1);
for my $in (sort keys %least) {
    cmp_ok scalar(grep { $run{ $_->{language} } && $_->{in} eq $in } @blocks), '>=', $least{$in}, "$in has blocks to run";
}
for my $block (@blocks) {
    my $language = $block->{language};
    ok $run{$language} || $elsewhere{$language}, "a block of $language in $block->{in} is run somewhere" or diag $block->{text};
    is_deeply [grep { !/^(?:docker|kubectl|voronoid (?:serve|stop|cancel)) / } split /\n/, $block->{text}], [], 'what is not run is docker\'s, or needs a proxy, a page or a job that runs'
        if $language eq 'console';
}
like Vt::slurp('.ci/run'), qr/^exec make gate$/m, 'continuous integration runs make gate';
my $gate = Vt::slurp('tests/support/gate.sh');
like $gate, qr/^step "$_" make /m, "which runs $_" for $readme =~ /^    (make \w+) +#/mg;

sub sphere {
    my ($path, $count) = @_;
    my $text = "ply\nformat ascii 1.0\nelement vertex $count\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    srand 5;
    for (1 .. $count) {
        my ($z, $a) = (2 * rand() - 1, 6.283185307 * rand());
        my $r = sqrt(1 - $z * $z);
        $text .= sprintf "%.6f %.6f %.6f\n", map { $_ / 2 } $r * cos $a, $r * sin $a, $z;
    }
    spew($path, $text);
}

my $recorder = do {
    # A port that was free a moment ago is the daemon's; the recorder has the one that the blocks name, if it can.
    my $port = IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 0, Listen => 1)->sockport;
    Recorder->start("127.0.0.1:$port", 8080);
};
my $binary = abs_path($ENV{VORONOID} // 'build/release/voronoid');
my $dir = tempdir(CLEANUP => 1);
mkdir "$dir/bin";
symlink $binary, "$dir/bin/voronoid";
sphere("$dir/cloud.ply", 1000);
spew("$dir/in.xyz", "1 2 3 255\n\n4e-3 5 6 0\n");

# The blocks, and our own client beside those of others.
my $session = join '', map { $run{ $_->{language} } ? $run{ $_->{language} }->($_->{text}) : '' } @blocks;
my $url = "http://$recorder->{address}";
my $own = <<"END";
voronoid health --server $url
voronoid resample cloud.ply -n 500 -q -o client.ply --server $url
voronoid inspect cloud.ply --json --server $url >inspect.json
! voronoid resample cloud.ply -n 0 -q -o none.ply --server $url
END
$session =~ s{http://127\.0\.0\.1:8080}{$url}g;
$session =~ s/^(?=kill %1)/$own/m or fail 'the session ends its daemon';
spew("$dir/readme.sh", "set -e -m\ntrap 'kill \$(jobs -p) 2>/dev/null || :' EXIT\n$session");
my $out = `cd $dir && VORONOID_LISTEN=$recorder->{to} XDG_STATE_HOME=$dir/state PATH=$dir/bin:\$PATH timeout 900 bash readme.sh 2>$dir/err`;
is $?, 0, 'README.md runs from top to bottom' or diag `tail -n 20 $dir/err`;
$recorder->stop;

my $head = sub { -e $_[0] ? substr Vt::slurp($_[0]), 0, 400 : '' };
is substr($head->("$dir/$_"), 0, 5), 'DRACO', "$_ is a Draco cloud" for qw(curl.drc even.drc coarse.drc cloud.drc far.drc);
my %points = ('from-js' => 5000, 'from-python' => 5000, form => 5000, zipped => 5000, few => 100, dense => 4000, sharp => 6000,
    piped => 2000, client => 500, fetched => 1000, out => 2, job => 250, 'out/cloud' => 1000, 'out/dense' => 1000);
like $head->("$dir/$_.ply"), qr/^element vertex $points{$_}$/m, "$_.ply has $points{$_} points" for sort keys %points;
like $head->("$dir/sharp.ply"), qr/^property float nx$/m, 'ear gives normals';
like $out, qr/^event: progress$/m, 'progress is streamed';
like $out, qr/^event: end$/m, 'the stream ends';
like $out, qr/"stopped": "iterations"/, 'the report says why it ended';
like $out, qr/^dismissed$/m, 'a finished job can be removed';
like $out, qr/points is 0, want a whole number from 1 to 10000000/, 'the mistake is named';
like $out, qr/^spacing\.mean +\S+ /m, 'inspect prints lines';
like `tar -tzf $dir/backup.tar.gz`, qr{^voronoid/jobs\.sqlite$}m, 'the backup has the table of jobs';

my $contract = Contract->new;
my @exchanges = $recorder->exchanges;
my %answered;
for my $exchange (@exchanges) {
    my ($operation, $route) = $contract->find(@$exchange{qw(method target)});
    $answered{ ($route // '') . " $exchange->{status}" }++;
    is_deeply [$contract->faults_of($exchange)], [], "$exchange->{method} $exchange->{target}: $exchange->{status}, "
        . ($exchange->{headers}{'content-type'} // 'no content');
}
ok $answered{$_}, "an answer to $_ was recorded" for 'GET /readyz 200', 'POST /v1/resample 200',
    'POST /v1/resample 201', 'POST /v1/resample 400', 'POST /v1/inspect 201', 'GET /v1/jobs/{jobID}/events 200',
    'GET /v1/jobs/{jobID}/results/{output} 200', 'DELETE /v1/jobs/{jobID} 200';

# The check can fail: the same answers, each with another status and another media type.
for my $exchange (grep { length $_->{body} } @exchanges) {
    my %headers = (%{ $exchange->{headers} }, 'content-type' => 'text/html');
    my @faults = ($contract->faults_of({ %$exchange, status => 418 }),
        $contract->faults_of({ %$exchange, headers => \%headers }));
    is scalar @faults, 2, "$exchange->{method} $exchange->{target}: 418 and text/html are no such answers";
}
done_testing;
